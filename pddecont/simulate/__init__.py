"""Trajectories: integration with events and resets, the attractors that motions lead to, sweeps and basins."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
