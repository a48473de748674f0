"""The symbolic model: from a YAML file to modes, events, resets, segments and delays as expressions."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
