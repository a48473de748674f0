"""Pictures of results files: the only code that imports matplotlib, and only when something is drawn."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
