"""Equilibria of one mode: their linearisation, and the points at which periodic orbits are born."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
