"""Solving and following systems of equations: residuals, Jacobians, tests and nothing of models or orbits."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
