"""Ticks whose numbers would cover one another are made fewer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

# Between numbers, as a share of the height of their letters.
GAP = 0.3
# Intervals between ticks, at the most, of matplotlib's own choice.
MAX_INTERVALS = 9


def thin_ticks(figure: Figure) -> None:
    """Give each axis as many ticks as its numbers have room for, beginning with what is there."""
    from matplotlib.ticker import MaxNLocator

    intervals: dict[Axis, int] = {}
    while True:
        # The panels' places depend on what is written beside them.
        figure.draw_without_rendering()
        crowded = [
            axis
            for axes in figure.axes
            if axes.get_visible() and axes.name != "3d"
            for axis, which in ((axes.xaxis, 0), (axes.yaxis, 1))
            if _is_crowded(axis, which) and intervals.get(axis, MAX_INTERVALS) > 1
        ]
        if not crowded:
            return
        for axis in crowded:
            shown = len(list_label_boxes(axis))
            intervals[axis] = max(1, min(intervals.get(axis, MAX_INTERVALS), shown) - 1)
            locator = axis.get_major_locator()
            assert isinstance(locator, MaxNLocator)
            locator.set_params(nbins=intervals[axis], min_n_ticks=1)


def list_label_boxes(axis: Axis) -> NDArray[np.float64]:
    """Return the boxes of an axis's numbers as they are drawn, in pixels: left, bottom, right, top, shape (n, 4)."""
    low, high = sorted(axis.get_view_interval())
    ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    labels = [label for tick in ticks for label in (tick.label1, tick.label2)]
    shown = [label for label in labels if label.get_visible() and label.get_text()]
    return np.array([label.get_window_extent().extents for label in shown]).reshape(-1, 4)


def _is_crowded(axis: Axis, which: int) -> bool:
    """Whether numbers that can be made fewer stand too near to one another, along x (0) or y (1)."""
    from matplotlib.ticker import MaxNLocator

    return isinstance(axis.get_major_locator(), MaxNLocator) and _overlap(list_label_boxes(axis), which)


def _overlap(boxes: NDArray[np.float64], which: int) -> bool:
    """Whether boxes (n, 4), which stand beside (0) or above (1) one another, are nearer than the gap."""
    if len(boxes) < 2:
        return False
    ordered = boxes[np.argsort(boxes[:, which])]
    gap = GAP * float(np.min(boxes[:, 3] - boxes[:, 1])) * (which == 0)
    return bool(np.any(ordered[1:, which] < ordered[:-1, which + 2] + gap))
