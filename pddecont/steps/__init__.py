"""Kinds of steps, each declared once, and the context that they are done in."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
