"""Numbers of each point in the complex plane: dots of all points, and those of some points as larger marks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.columns import describe_point, list_free_parameters, read_column
from pddecont.plot.special_points import read_kind
from pddecont.plot.style import COLOURS, LINES_ONLY, OTHER_MARKER, find_marker
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection

Complex = NDArray[np.complex128]


def draw_spectra(axes: Axes, step: Step, values: Sequence[Complex]) -> PathCollection | None:
    """Draw the numbers of each row as dots, coloured by the free parameter.

    Returns what a colour bar shows; None where there is no free parameter or only one point.
    """
    z, free = np.concatenate(values), list_free_parameters(step)
    if not free or len(step) == 1:
        axes.scatter(z.real, z.imag, s=14, color=COLOURS[0], zorder=3)
        return None
    owners = np.repeat(np.arange(len(step)), [len(v) for v in values])
    return axes.scatter(
        z.real, z.imag, s=7, c=read_column(step, free[0])[owners], cmap="viridis", linewidth=0, zorder=3
    )


def emphasise_spectrum(axes: Axes, step: Step, row: int, k: int, z: Complex) -> None:
    """Draw the numbers of a point as the marker of its kind, larger and in another colour for each ``k``."""
    shape = find_marker(read_kind(step, row)) if step.labels[row] else OTHER_MARKER
    colour = COLOURS[k % len(COLOURS)]
    fill: dict[str, Any] = {"color": colour} if shape in LINES_ONLY else {"facecolor": "none", "edgecolor": colour}
    label = describe_point(step, row) or f"index {row}"
    axes.scatter(z.real, z.imag, s=40 + 26 * k, marker=shape, linewidth=1.4, zorder=4, label=label, **fill)
