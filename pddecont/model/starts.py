"""Whether a motion starts beyond an event that ends the segment it starts in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from pddecont.model.evaluation import evaluate
from pddecont.model.expression import TIME
from pddecont.model.lagged import make_symbol
from pddecont.model.syntax import ExpressionError
from pddecont.model.system import Model
from pddecont.model.transitions import list_transitions

ROUNDING = 1e-9
# Functions that come back to zero whatever their argument does: a state that is a clock has passed such an event many
# times.
PERIODIC = (sympy.sin, sympy.cos, sympy.tan)


def explain_start_beyond_event(
    model: Model, mode: str, states: Sequence[float], parameters: Mapping[str, float]
) -> str:
    """Return why a motion that starts in ``mode`` with ``states`` does not meet an event it seems to have met already.

    The text is empty if it does.

    Event functions of t, of delayed values and of angles say nothing of the past, and neither do events watched in both
    directions.
    """
    numbers = {make_symbol(name): v for name, v in parameters.items()} | dict(
        zip(model.state_symbols, states, strict=True)
    )
    surfaces = list_transitions(model, mode).surfaces
    for (event, _), segment in surfaces.items():
        h = model.events[event].function
        ways = [way for other, way in surfaces if other == event]
        if h is None or len(ways) > 1 or segment.direction == "any" or h.has(TIME, *model.read_symbols, *PERIODIC):
            continue
        at_start = evaluate(h, numbers)
        if (at_start > ROUNDING) if segment.direction == "rising" else (at_start < -ROUNDING):
            sign, other = (">", "negative") if segment.direction == "rising" else ("<", "positive")
            return (
                f"the motion starts in mode '{mode}' with {h} = {at_start:.6g} {sign} 0, beyond event "
                f"'{segment.event}', which ends "
                f"that mode where this is {segment.direction} through zero; start where it is {other}, or in another "
                f"mode"
            )
    return ""


def explain_own_start(model: Model) -> str:
    """Return the same of the model's own start; empty where its history has no value at t = 0."""
    try:
        states = [model.evaluate(e, time=0.0) for e in model.history]
    except ExpressionError:
        return ""
    return explain_start_beyond_event(model, model.initial_mode, states, model.parameters)
