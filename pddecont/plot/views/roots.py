"""Characteristic roots of equilibria in the complex plane."""

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
from pddecont.tables import holds_equilibria, read_roots

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

# Roots farther from zero than so many times the largest leading root are not shown: they would hide the axis.
FARTHEST = 5.0
# Room around what is shown, as a share of its size.
MARGIN = 0.06


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the roots of a step, with those of chosen or special points emphasised."""
    step, rows = steps[0], [row for _, row in select_points(steps, request, ends=False)]
    figure, axes = make_axes(6.4, 5.2)
    dots = draw_roots(axes, step, rows)
    if dots is not None:
        figure.colorbar(dots, ax=axes, label=format_axis_label(step, list_free_parameters(step)[0]), shrink=0.85)
    add_legend(figure, axes.get_legend_handles_labels()[0], max_columns=2)
    return figure


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the last step that has roots, a branch before a curve, along which some stay on the axis."""
    full = [step for step in steps if has_roots(step)]
    return ([step for step in full if len(list_free_parameters(step)) < 2] or full or steps)[-1:]


def has_roots(step: Step) -> bool:
    """Return whether there is a characteristic root at any point."""
    return holds_equilibria(step) and len(step.orbits.get("roots", ())) > 0


def draw_roots(axes: Axes, step: Step, rows: Sequence[int]) -> PathCollection | None:
    """Draw the roots of all points, coloured by the free parameter, and those of ``rows`` emphasised.

    Returns what a colour bar shows; None where there is no free parameter or only one point.

    Raises
    ------
    ResultsError
        If the step has no roots.
    """
    if not has_roots(step):
        raise ResultsError(f"step '{step.name}' holds no characteristic roots")
    axes.axvline(0.0, color="0.35", lw=1.0, label="_imaginary axis")
    values = [read_roots(step, i) for i in range(len(step))]
    dots = draw_spectra(axes, step, values)
    for k, row in enumerate(rows):
        emphasise_spectrum(axes, step, row, k, values[row])
    _set_limits(axes, values)
    return dots


def _set_limits(axes: Axes, values: Sequence[NDArray[np.complex128]]) -> None:
    """Show the imaginary axis and what lies near zero, as leading roots go; say what lies beyond."""
    z = np.concatenate(values)
    reach = FARTHEST * max((float(np.abs(found[0])) for found in values if len(found)), default=0.0) or 1.0
    shown = z[np.abs(z) <= reach]
    low, high = min(0.0, *shown.real, 0.0), max(0.0, *shown.real, 0.0)
    top = max(0.0, *np.abs(shown.imag), 0.0)
    gap_x = MARGIN * (high - low or reach)
    gap_y = MARGIN * 2.0 * (top or 0.5 * reach)
    axes.set_xlim(low - gap_x, high + gap_x)
    axes.set_ylim(-top - gap_y, top + gap_y)
    axes.set_xlabel(f"real part of {format_name('lambda')}")
    axes.set_ylabel(f"imaginary part of {format_name('lambda')}")
    if len(shown) < len(z):
        text = f"{len(z) - len(shown)} farther from zero, up to {np.max(np.abs(z)):.3g}"
        axes.text(0.02, 0.98, text, transform=axes.transAxes, va="top", fontsize=8)


DRAWING = Drawing(draw_figure, stands_alone=has_roots, choose_steps=choose_steps)
