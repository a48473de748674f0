"""Floquet multipliers in the complex plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.plot.axis_labels import format_axis_label, format_name
from pddecont.plot.columns import list_free_parameters
from pddecont.plot.layouts import make_axes
from pddecont.plot.legend import add_legend
from pddecont.plot.point_selection import select_points
from pddecont.plot.spectra import draw_spectra, emphasise_spectrum
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Results, Step
from pddecont.tables import has_multipliers, read_multipliers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

# The largest modulus that is shown: that of a grazing orbit may be a million, and hide the unit circle.
FARTHEST = 3.0
# Room around what is shown, as a share of its size.
MARGIN = 0.06


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the multipliers of a step, with those of chosen or special points emphasised."""
    step, rows = steps[0], [row for _, row in select_points(steps, request, ends=False)]
    figure, axes = make_axes(6.4, 5.2)
    dots = draw_multipliers(axes, step, rows)
    if dots is not None:
        figure.colorbar(dots, ax=axes, label=format_axis_label(step, list_free_parameters(step)[0]), shrink=0.85)
    add_legend(figure, axes.get_legend_handles_labels()[0], max_columns=2)
    return figure


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the last step that has multipliers, else the last."""
    return ([step for step in steps if has_multipliers(step)] or steps)[-1:]


def draw_multipliers(axes: Axes, step: Step, rows: Sequence[int]) -> PathCollection | None:
    """Draw the multipliers of all points, coloured by the free parameter, and those of ``rows`` emphasised.

    Returns what a colour bar shows; None where there is no free parameter or only one point.

    Raises
    ------
    ResultsError
        If the step, or a point of ``rows``, has no multipliers.
    """
    if not has_multipliers(step):
        raise ResultsError(f"step '{step.name}' has no multipliers; run it with 'stability: true'")
    for row in rows:
        if not len(read_multipliers(step, row)):
            raise ResultsError(
                f"step '{step.name}' has no multipliers at point {step.labels[row] or row}; "
                "choose another --label or --index"
            )
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color="0.35", lw=1.0, label="_unit circle")
    values = [read_multipliers(step, i) for i in range(len(step))]
    dots = draw_spectra(axes, step, values)
    for k, row in enumerate(rows):
        emphasise_spectrum(axes, step, row, k, values[row])
    _set_limits(axes, np.concatenate(values))
    return dots


def _set_limits(axes: Axes, z: NDArray[np.complex128]) -> None:
    """Show the unit circle and what lies within :data:`FARTHEST` of zero; say what lies outside."""
    shown = z[np.abs(z) <= FARTHEST]
    low_x, high_x = min(-1.0, *shown.real, -1.0), max(1.0, *shown.real, 1.0)
    high_y = max(1.0, *np.abs(shown.imag), 1.0)
    gap = MARGIN * max(high_x - low_x, 2.0 * high_y)
    axes.set_xlim(low_x - gap, high_x + gap)
    axes.set_ylim(-high_y - gap, high_y + gap)
    axes.set_aspect("equal")
    axes.set_xlabel(f"real part of {format_name('mu')}")
    axes.set_ylabel(f"imaginary part of {format_name('mu')}")
    if len(shown) < len(z):
        text = f"{len(z) - len(shown)} outside, up to modulus {np.max(np.abs(z)):.3g}"
        axes.text(0.02, 0.98, text, transform=axes.transAxes, va="top", fontsize=8)


DRAWING = Drawing(draw_figure, stands_alone=has_multipliers, choose_steps=choose_steps)
