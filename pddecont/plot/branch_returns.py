"""Where the orbits of branches return to the section of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.branch_colours import make_style_handles
from pddecont.plot.branch_parts import split_branch
from pddecont.plot.columns import find_state, read_parameter
from pddecont.plot.interpolated_orbits import interpolate_segments
from pddecont.plot.legend import make_line_handle
from pddecont.plot.point_labels import PointLabel
from pddecont.plot.special_points import find_special_rows, read_kind
from pddecont.plot.style import find_marker
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# Of branches under the dots of a sweep: thin and grey.
COLOUR, WIDTH = "0.45", 0.9


def draw_branch_returns(
    axes: Axes, branches: Sequence[Step], sweep: Step, x: str, state: str
) -> tuple[list[PointLabel], list[Artist]]:
    """Draw where the orbits of branches return to a sweep's section: solid lines are stable, dashed ones unstable.

    Returns the labels of special points, which go in last, and the handles of the legend.
    """
    labels: list[PointLabel] = []
    drawn = []
    for branch in branches:
        xs, j = read_parameter(branch, x), find_state(branch, state)
        for part in split_branch(branch):
            returns = [find_returns(branch, int(row), j, sweep) for row in part.rows]
            n = min((len(values) for values in returns), default=0)
            if n == 0:
                continue
            for values in join_returns([found[:n] for found in returns]).T:
                axes.plot(xs[part.rows], values, ls=part.style, color=COLOUR, lw=WIDTH, zorder=1)
            drawn.append(branch)
        for row in find_special_rows(branch):
            values = find_returns(branch, row, j, sweep)
            marker = find_marker(read_kind(branch, row))
            axes.plot(np.full(len(values), xs[row]), values, marker=marker, ls="", color="black", ms=4, zorder=5)
            labels += [PointLabel(branch.labels[row], float(xs[row]), float(value)) for value in values[:1]]
    if not drawn:
        return labels, []
    handles = make_style_handles(drawn, COLOUR, lw=WIDTH) or [make_line_handle("orbits", color=COLOUR, lw=WIDTH)]
    for handle in handles:
        handle.set_label(f"followed: {handle.get_label()}")
    return labels, handles


def join_returns(returns: Sequence[Array]) -> Array:
    """Return the returns of neighbouring orbits, (n,) each, turned so that each continues the nearest one before.

    The result has shape (n_orbits, n).
    """
    joined = [returns[0]]
    for values in returns[1:]:
        turned = [np.roll(values, k) for k in range(len(values))]
        joined.append(min(turned, key=lambda v: float(np.max(np.abs(v - joined[-1])))))
    return np.array(joined)


def find_returns(branch: Step, row: int, j: int, sweep: Step) -> Array:
    """Return state ``j`` of an orbit where it returns to a sweep's section, shape (n_returns,).

    It is empty where the section is no phase of the forcing, for then a branch does not record where it is.
    """
    section = sweep.meta["section"]
    if "phase" not in section:
        return np.empty(0)
    arcs = interpolate_segments(branch, row)
    n = int(branch.points["n_periods"][row])
    period = float(branch.points["period"][row]) / n
    start, end = arcs[0][0][0], arcs[-1][0][-1]
    times = (np.ceil(start / period - section["phase"]) + section["phase"] + np.arange(n)) * period
    times = start + (times - start) % (end - start)
    found = []
    for time in times:
        arc_times, values = next((arc for arc in arcs if arc[0][0] <= time <= arc[0][-1]), arcs[-1])
        found.append(float(np.interp(time, arc_times, values[:, j])))
    return np.array(found)
