"""Piecewise polynomials on a mesh that moves with segment durations and delays; knows no orbit."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
