"""Periodic orbits of hybrid delay equations by collocation: equations, meshes, errors, what is measured on them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
