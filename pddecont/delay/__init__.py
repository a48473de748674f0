"""Ways to discretise the delay, one a file, behind one interface; where delays carry the jumps of derivatives."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
