"""Dist(N): how far chains of N stages are from the delay equation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pddecont.plot.style import COLOURS, INNER_LEGEND_SIZE, TITLE_SIZE
from pddecont.results import Step
from pddecont.tables import measure_distances

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Of the methods that a precision step compares, one after the other.
METHOD_MARKERS = "os^DvPX*"


def draw_distances(axes: Axes, step: Step, title: str) -> None:
    """Draw Dist(N) of each chain on logarithmic axes with its order."""
    for (name, (n, distance, order)), colour, mark in zip(
        measure_distances(step).items(), COLOURS, METHOD_MARKERS, strict=False
    ):
        text = f"{name}: p = {order:.2f}" if np.isfinite(order) else name
        axes.plot(n, distance, f"-{mark}", ms=3.5, color=colour, label=text)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("N")
    axes.set_ylabel("Dist(N)")
    axes.set_title(title, fontsize=TITLE_SIZE)
    axes.legend(fontsize=INNER_LEGEND_SIZE)
