"""Bifurcation analysis of piecewise-smooth delay differential equations.

``pddecont.run`` does a run, ``pddecont.explore`` a whole diagram, and ``pddecont.load`` reads results, in Python as on
the command line.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from pddecont.version import __version__

if TYPE_CHECKING:
    from pddecont.api import Orbit as Orbit
    from pddecont.api import Point as Point
    from pddecont.api import RunResults as RunResults
    from pddecont.api import StepResults as StepResults
    from pddecont.api import Table as Table
    from pddecont.api import explore as explore
    from pddecont.api import load as load
    from pddecont.api import run as run

__all__ = ["Orbit", "Point", "RunResults", "StepResults", "Table", "__version__", "explore", "load", "run"]


def __getattr__(name: str) -> Any:
    """Import the Python interface when it is first used: the command line starts without it."""
    if name not in __all__:
        raise AttributeError(f"module 'pddecont' has no attribute '{name}'")
    return getattr(importlib.import_module("pddecont.api"), name)


def __dir__() -> list[str]:
    """Return the names of the Python interface."""
    return __all__
