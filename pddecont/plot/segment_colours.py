"""Colours of orbits: a segment has one in all panels, and none that means something else in a diagram beside them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pddecont.plot.branch_colours import assign_branch_colours
from pddecont.plot.branch_parts import find_family
from pddecont.plot.special_points import read_curve_sort
from pddecont.plot.style import make_palette
from pddecont.results import Step
from pddecont.tables import find_signature

Row = tuple[Step, int]
# Of an orbit whose signature the diagram does not show.
OTHER = "0.35"


def list_segments(step: Step, row: int) -> list[str]:
    """Return the names of the segments of a recorded orbit, in order."""
    return find_signature(step, row).split()


def has_several_names(step: Step, row: int) -> bool:
    """Return whether an orbit has segments of more than one name."""
    return len(set(list_segments(step, row))) > 1


def assign_segment_colours(rows: Sequence[Row], taken: Sequence[str] = ()) -> dict[str, str]:
    """Return a colour for each segment of the orbits ``rows`` by its name, none of those ``taken``."""
    names = list(dict.fromkeys(name for step, row in rows for name in list_segments(step, row)))
    left = [colour for colour in make_palette(len(names) + len(taken)) if colour not in taken]
    return dict(zip(names, left, strict=False))


def match_diagram(steps: Sequence[Step], rows: Sequence[Row]) -> list[dict[str, str]]:
    """Return the colours of the segments of each orbit beside the diagram of branches."""
    colours = assign_branch_colours(steps)
    return _match(
        rows,
        lambda step, row: colours.of_parts.get((step.name, find_family(step, row)), OTHER),
        [colour for _, colour in colours.in_legend],
    )


def match_plane(steps: Sequence[Step], rows: Sequence[Row]) -> list[dict[str, str]]:
    """Return the colours of the segments of each orbit beside the plane of curves in two parameters."""
    taken = [read_curve_sort(step).colour for step in steps]
    return _match(rows, lambda step, row: read_curve_sort(step).colour, taken)


def _match(rows: Sequence[Row], find_colour: Callable[[Step, int], str], taken: Sequence[str]) -> list[dict[str, str]]:
    """Return the colours of each orbit: of one kind of segment its line's in the diagram, else some that are left."""
    several = assign_segment_colours([row for row in rows if has_several_names(*row)], taken)
    return [
        several if has_several_names(*row) else dict.fromkeys(list_segments(*row), find_colour(*row)) for row in rows
    ]
