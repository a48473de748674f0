"""Intervals that hold all values of a function over boxes, and all zeros of equations in a box; knows no model."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
