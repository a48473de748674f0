"""The mode that holds where a motion rests."""

from __future__ import annotations

from pddecont.equilibrium.equations import Equilibrium
from pddecont.model import find_start_mode


def read_mode(at: Equilibrium) -> str:
    """Return the mode that states say, of a model given by its equations; else the equilibrium's own.

    Raises
    ------
    UndecidedSlidingError
        If both fields point away from a surface on which it lies.
    """
    model = at.motion.numeric.model
    if model.derived is None:
        return at.motion.mode
    numbers = dict(zip(model.parameter_symbols, at.parameters.tolist(), strict=True))
    numbers |= dict(zip(model.state_symbols, at.states.tolist(), strict=True))
    numbers |= dict(zip(model.read_symbols, at.motion.read(at.states, at.parameters).tolist(), strict=True))
    return find_start_mode(model.derived, numbers)
