"""Sliding motions are kept on their surfaces: what a step's error moves them off is taken back at its end."""

from __future__ import annotations

from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_functions import evaluate_event, evaluate_event_slope
from pddecont.native.integrator.places import MODE

# Rounds over the surfaces: of several that are not at right angles each moves the motion off the others a little.
ROUNDS = 4


def return_to_surfaces(c: Core, t: float, h: float) -> None:
    """Move the states to where the functions of the surfaces of the present mode are zero.

    Each state takes a share of the way: that of its term in the function, by its size and its change in the step of
    length ``h``, so that units do not matter.
    """
    mode = c.count[MODE]
    first, last = c.held_first[mode], c.held_first[mode + 1]
    for _ in range(ROUNDS if last - first > 1 else 1):
        for place in range(first, last):
            event = c.held_event[place]
            evaluate_event_slope(c, event, mode, t, c.y)
            whole = 0.0
            for i in range(c.n):
                whole += abs(c.gradient[i]) * (abs(c.y[i]) + abs(h * c.slope[i]))
            if whole == 0.0:
                continue
            for i in range(c.n):
                c.trial[i] = (abs(c.y[i]) + abs(h * c.slope[i])) * (1.0 if c.gradient[i] > 0.0 else -1.0)
                if c.gradient[i] == 0.0:
                    c.trial[i] = 0.0
            # Event functions leave their value where the gradient was.
            value = evaluate_event(c, event, t, c.y)
            for i in range(c.n):
                c.y[i] -= value / whole * c.trial[i]
