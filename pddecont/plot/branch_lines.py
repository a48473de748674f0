"""Branches as lines, each part in its style."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from pddecont.plot.branch_parts import LineStyle, OrbitFamily, split_branch
from pddecont.plot.columns import read_column
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# How much thinner than the others, in points, the parts are that are not admissible.
THINNER = 0.6


def draw_parts(
    axes: Axes, step: Step, columns: tuple[str, str], find_colour: Callable[[Step, OrbitFamily], str], width: float
) -> None:
    """Draw a branch, the second of two columns over the first, in the colour of each part's family.

    Unstable parts are dashed, those that are not admissible dotted and thinner than the ``width`` in points; one or two
    points alone are marked.
    """
    xs, ys = (read_column(step, name) for name in columns)
    for part in split_branch(step):
        axes.plot(
            xs[part.rows],
            ys[part.rows],
            ls=part.style,
            color=find_colour(step, part.family),
            lw=width - THINNER * (part.style == LineStyle.DOTTED),
            marker="." if len(xs) < 3 else None,
        )
