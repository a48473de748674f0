"""What is known of a diagram so far: motions told apart however they are written, branches that they lie on."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
