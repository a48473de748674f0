"""Branches as lines, each part in its style."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.branch_parts import Family, LineStyle, split_branch
from pddecont.plot.smooth_lines import PIECES, slice_part, smooth_branch
from pddecont.results import Step
from pddecont.tables import holds_equilibria

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# How much thinner than the others, in points, the parts are that are not admissible.
THINNER = 0.6
# What marks points that lie on no branch, by the line that they would be.
MARKS = {
    LineStyle.SOLID: {"marker": "o", "fillstyle": "full"},
    LineStyle.DASHED: {"marker": "o", "fillstyle": "none"},
    LineStyle.DOTTED: {"marker": "x"},
}


def draw_parts(
    axes: Axes,
    step: Step,
    columns: Array,
    find_colour: Callable[[Step, Family], str],
    width: float,
    slopes: Array | None = None,
) -> None:
    """Draw a branch, ``columns`` (1 + n_lines, n_points) over the first one, in the colours of its families.

    ``slopes`` are those of the columns along the branch, as :func:`smooth_branch` takes them.
    Unstable parts are dashed, those that are not admissible dotted and thinner than the ``width`` in points; one or two
    points alone are marked, and so are points that lie on no branch (:data:`MARKS`).
    """
    line = smooth_branch(step, columns, slopes) if step.format.has_branch else None
    for part in split_branch(step):
        style: dict[str, Any] = {"ls": part.style, "marker": "." if columns.shape[1] < 3 else None}
        if not step.format.has_branch and holds_equilibria(step):
            style = {"ls": "", **MARKS[part.style]}
        shown_xs, *shown = columns[:, part.rows] if line is None else line[:, slice_part(part)]
        for ys in shown:
            axes.plot(
                shown_xs,
                ys,
                color=find_colour(step, part.family),
                lw=width - THINNER * (part.style == LineStyle.DOTTED),
                **style,
            )


def draw_birth(
    axes: Axes,
    step: Step,
    place: tuple[float, float],
    xs: Array,
    heights: Array,
    find_colour: Callable[[Step, Family], str],
    width: float,
) -> None:
    """Join the first orbits of a branch to the Hopf point at ``place`` at which they are born.

    Their extent, lines ``heights`` (n_lines, n_points), differs from the equilibrium as the amplitude does, the
    parameter ``xs`` (n_points,) as its square.
    """
    part = split_branch(step)[0]
    row = part.rows[0]
    share = np.linspace(0.0, 1.0, PIECES + 1)
    for height in heights[:, row]:
        axes.plot(
            place[0] + share**2 * (xs[row] - place[0]),
            place[1] + share * (height - place[1]),
            color=find_colour(step, part.family),
            ls=part.style,
            lw=width,
        )
