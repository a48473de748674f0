"""Run files: their shape, what is wrong with them, and the plan that a run follows."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
