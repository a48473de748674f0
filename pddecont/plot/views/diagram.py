"""Bifurcation diagrams: any column of points against any other, one or several branches of orbits and equilibria."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.births import find_birth
from pddecont.plot.branch_colours import BranchColours, assign_branch_colours, make_style_handles
from pddecont.plot.branch_lines import draw_birth, draw_parts
from pddecont.plot.branch_parts import Family
from pddecont.plot.columns import keep_comparable, list_free_parameters, read_column
from pddecont.plot.heights import choose_columns, read_heights
from pddecont.plot.layouts import count_beside, finish_figure, make_panel_beside_orbits
from pddecont.plot.limits import widen_for_columns
from pddecont.plot.point_labels import PointLabel
from pddecont.plot.point_selection import select_orbits
from pddecont.plot.segment_colours import match_diagram
from pddecont.plot.slopes import read_slopes
from pddecont.plot.special_points import mark_special_points, name_apart
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Results, Step

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Of lines, in points.
WIDTH = 1.6


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the diagram with phase plots of chosen or special points beside it."""
    x, y = choose_columns(steps)
    rows = select_orbits(steps, request, count_beside())
    figure, axes = make_panel_beside_orbits(steps, rows, match_diagram(steps, rows))
    return finish_figure(figure, axes, *draw_diagram(axes, steps, request.x or x, request.y or y))


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the branches in the last one's parameter, at its values of the others; curves only without branches."""
    return keep_comparable([step for step in steps if len(list_free_parameters(step)) == 1] or steps)


def draw_diagram(
    axes: Axes, steps: Sequence[Step], x: str, y: str, colours: BranchColours | None = None
) -> tuple[list[PointLabel], list[Artist]]:
    """Draw branches: unstable parts dashed, not admissible ones dotted, in ``colours`` or those of signatures.

    Where ``y`` is a state equilibria are one line, and orbits two: the state's largest and its smallest value. Returns
    the labels of special points, which go in last, and the handles of the legend. Branches that ``y`` says nothing of
    are left out.
    """
    steps = [step for step in steps if np.isfinite(read_heights(step, y)).any()] or steps
    chosen = colours or assign_branch_colours(steps)

    def find_colour(step: Step, family: Family) -> str:
        return chosen.of_parts[step.name, family]

    labels: dict[str, list[PointLabel]] = {}
    columns, heights = [read_column(step, x) for step in steps], [read_heights(step, y) for step in steps]
    for step, xs, lines in zip(steps, columns, heights, strict=True):
        slopes = np.vstack([read_slopes(step, x), read_slopes(step, y)])
        draw_parts(axes, step, np.vstack([xs, lines]), find_colour, WIDTH, slopes)
        birth = find_birth(step, steps)
        if birth and len(lines) > 1:
            source, row = birth
            place = float(read_column(source, x)[row]), float(read_heights(source, y)[0, row])
            draw_birth(axes, step, place, xs, lines, find_colour, WIDTH)
        labels[step.name] = mark_special_points(axes, step, xs, lines)
    widen_for_columns(axes, steps, {"x": columns, "y": heights})
    axes.set_xlabel(format_axis_label(steps, x))
    axes.set_ylabel(format_axis_label(steps, y))
    return name_apart(labels), [*chosen.make_handles(), *make_style_handles(steps)]


DRAWING = Drawing(draw_figure, choose_steps=choose_steps)
