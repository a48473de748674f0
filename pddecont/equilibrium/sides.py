"""Whether an equilibrium lies where its mode does: on the near side of each event that ends the mode.

A mode ends where an event function rises through zero, or falls: motions in it have that function below zero, or above.
An equilibrium on the other side is virtual: its mode never holds there.
"""

from __future__ import annotations

from dataclasses import dataclass

from pddecont.equilibrium.equations import Equilibrium
from pddecont.model import Model

SIGNS = {"rising": 1.0, "falling": -1.0}


@dataclass(frozen=True)
class Side:
    """An event that ends a mode, its function below zero in the mode if ``sign`` is +1 and above if it is -1.

    ``segments`` are the names of what happens there.
    """

    event: str
    sign: float
    segments: tuple[str, ...]

    def measure(self, at: Equilibrium) -> float:
        """Return how far an equilibrium is from the event's surface, positive where its mode holds."""
        return -self.sign * at.motion.measure_event(self.event, at.states, at.parameters)[0]


def list_sides(model: Model, mode: str) -> list[Side]:
    """Return the events that bound a mode on one side."""
    found: dict[tuple[str, float], list[str]] = {}
    for segment in model.list_segments(mode):
        function = model.events[segment.event].function if segment.event else None
        if function is not None and segment.direction in SIGNS:
            found.setdefault((segment.event, SIGNS[segment.direction]), []).append(segment.name)
    both = {event for event, sign in found if (event, -sign) in found}
    return [Side(event, sign, tuple(names)) for (event, sign), names in found.items() if event not in both]


def find_passed_side(at: Equilibrium, on: str = "") -> Side | None:
    """Return an event beyond which a virtual equilibrium lies; None for one of its mode.

    An equilibrium that lies ``on`` the surface of an event is on neither side of it.
    """
    sides = list_sides(at.motion.numeric.model, at.motion.mode)
    return next((side for side in sides if side.event != on and not side.measure(at) >= 0.0), None)
