"""Orbits in the plane of two states: a panel a point, or several steps' orbits over one another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pddecont.plot.columns import choose_states, describe_differences, describe_point
from pddecont.plot.layouts import make_panels, name_segments
from pddecont.plot.phase_plot import draw_orbit, draw_orbits_together
from pddecont.plot.point_selection import select_points
from pddecont.plot.segment_colours import assign_segment_colours
from pddecont.plot.style import INNER_LEGEND_SIZE
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.plot.views import profile
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return a panel for each chosen point; of a model with one state its profile instead."""
    if len(steps[0].meta["states"]) == 1:
        return profile.draw_figure(steps, request)
    if len(steps) > 1:
        return _draw_by_parameters(steps, request)
    rows = select_points(steps, request)
    figure, panels = make_panels(len(rows))
    colours = assign_segment_colours(rows)
    for axes, (step, row) in zip(panels, rows, strict=True):
        draw_orbit(axes, step, row, *choose_states(step, request.x, request.y), colours, describe_point(step, row))
    name_segments(panels, rows)
    return figure


def _draw_by_parameters(steps: list[Step], request: ViewRequest) -> Figure:
    """Return a panel for each set of parameters with all orbits that have them, one over the other."""
    groups: dict[tuple[float, ...], list[Step]] = {}
    for step in steps:
        groups.setdefault(tuple(step.points["parameters"][0]), []).append(step)
    figure, panels = make_panels(len(groups))
    titles = describe_differences(steps[0].meta["parameters"], np.array(list(groups)))
    for axes, group, title in zip(panels, groups.values(), titles, strict=True):
        draw_orbits_together(axes, group, *choose_states(steps[0], request.x, request.y), title)
        axes.legend(fontsize=INNER_LEGEND_SIZE)
    return figure


DRAWING = Drawing(draw_figure)
