"""What equations of orbits are put together with, at all their points: plain Python, compiled with the package."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
