"""Surfaces of a mode made of equations: those that it slides along, those that it is beside, and how it leaves them."""

from __future__ import annotations

from pddecont.model.derived_modes import DerivedModes
from pddecont.model.endings import Crossing
from pddecont.model.switches import ON


def list_surfaces(derived: DerivedModes, mode: str) -> tuple[str, ...]:
    """Return the events whose functions are the surfaces that a motion slides along in a mode."""
    return tuple(event.name for event in derived.finder.list_held(derived.find_digits(mode)))


def find_surface(derived: DerivedModes, mode: str, event: str) -> int | None:
    """Return the switch whose surface an event is in a mode beside it; None for other events."""
    digits, switches = derived.find_digits(mode), derived.equations.switches
    beside = (k for k, d in enumerate(digits) if d != ON and not switches[k].remembers and switches[k].contact is None)
    return next((k for k in beside if derived.finder.name_surface(k, digits).name == event), None)


def list_exits(derived: DerivedModes, mode: str) -> list[tuple[str, Crossing]]:
    """Return the events at which motions cease to slide in a mode, and what they do."""
    crossings = ((ending.segment.event, ending.crossing) for ending in derived.list_endings(mode))
    return [(event, crossing) for event, crossing in crossings if crossing is not None and crossing.leaves]
