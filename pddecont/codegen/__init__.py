"""From symbols to functions of numbers: one printer, a backend a file."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
