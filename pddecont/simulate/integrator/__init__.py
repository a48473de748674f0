"""The compiled integrator: functions of arrays and numbers that numba turns into machine code."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
