"""Colours of orbits: a segment has one in all panels, and none that means something else in a diagram beside them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pddecont.plot.orbits import segment_names
from pddecont.plot.plane import curve_colour
from pddecont.plot.stretches import colouring, family
from pddecont.plot.style import palette
from pddecont.results.reader import Step

Row = tuple[Step, int]
# Of an orbit whose signature the diagram does not show.
OTHER = "0.35"


def segment_colours(rows: Sequence[Row], taken: Sequence[str] = ()) -> dict[str, str]:
    """Return a colour for each segment of the orbits ``rows`` by its name, none of those ``taken``."""
    names = list(dict.fromkeys(name for step, row in rows for name in segment_names(step, row)))
    left = [colour for colour in palette(len(names) + len(taken)) if colour not in taken]
    return dict(zip(names, left, strict=False))


def beside_diagram(steps: Sequence[Step], rows: Sequence[Row]) -> list[dict[str, str]]:
    """Return the colours of the segments of each orbit beside the diagram of branches."""
    families, handles = colouring(steps)
    return _beside(rows, lambda step, row: families.get((step.name, family(step, row)), OTHER), [h.get_color() for h in handles])


def beside_plane(steps: Sequence[Step], rows: Sequence[Row]) -> list[dict[str, str]]:
    """Return the colours of the segments of each orbit beside the plane of curves in two parameters."""
    return _beside(rows, lambda step, row: curve_colour(step), [curve_colour(step) for step in steps])


def several_segments(step: Step, row: int) -> bool:
    """Whether an orbit has segments of more than one name."""
    return len(set(segment_names(step, row))) > 1


def _beside(rows: Sequence[Row], colour_of: Callable[[Step, int], str], taken: Sequence[str]) -> list[dict[str, str]]:
    """Return the colours of each orbit: its line's in the diagram, where there is one kind of segment, else some that are left."""
    several = segment_colours([row for row in rows if several_segments(*row)], taken)
    return [several if several_segments(*row) else dict.fromkeys(segment_names(*row), colour_of(*row)) for row in rows]
