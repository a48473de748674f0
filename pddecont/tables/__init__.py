"""What is worked out from a results file: tables, classes of attractors, summaries, and words for what it holds."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
