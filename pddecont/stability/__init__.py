"""Floquet multipliers of periodic orbits: the linearised motion from period to period, and its eigenvalues."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
