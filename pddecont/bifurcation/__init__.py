"""Special points of branches, one kind a file: how they are found, defined, followed and gone on from."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
