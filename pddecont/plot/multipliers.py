"""Floquet multipliers in the complex plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.plot.columns import column, free_of, title
from pddecont.plot.style import COLOURS, LINES_ONLY, OTHER_MARKER, label, marker
from pddecont.results.reader import Step
from pddecont.results.tables import has_multipliers, multipliers

FARTHEST = 3.0


def draw_multipliers(axes: Any, step: Step, rows: Sequence[int]) -> Any:
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
        if not len(multipliers(step, row)):
            raise ResultsError(f"step '{step.name}' has no multipliers at point {step.labels[row] or row}; "
                               "choose another --label or --index")  # fmt: skip
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color="0.35", lw=1.0, label="_unit circle")
    values = [multipliers(step, i) for i in range(len(step))]
    dots = _draw_dots(axes, step, np.concatenate(values), np.repeat(np.arange(len(step)), [len(v) for v in values]))
    for k, row in enumerate(rows):
        shape, colour = marker(step.labels[row][:2]) if step.labels[row] else OTHER_MARKER, COLOURS[k % len(COLOURS)]
        z = multipliers(step, row)
        look: dict[str, Any] = {"color": colour} if shape in LINES_ONLY else {"facecolor": "none", "edgecolor": colour}
        axes.scatter(z.real, z.imag, s=40 + 26 * k, marker=shape, linewidth=1.4, zorder=4, label=title(step, row) or f"index {row}", **look)
    _set_limits(axes, np.concatenate(values))
    return dots


def _draw_dots(axes: Any, step: Step, z: Any, owner: Any) -> Any:
    free = free_of(step)
    if not free or len(step) == 1:
        axes.scatter(z.real, z.imag, s=14, color=COLOURS[0], zorder=3)
        return None
    return axes.scatter(z.real, z.imag, s=7, c=column(step, free[0])[owner], cmap="viridis", linewidth=0, zorder=3)


def _set_limits(axes: Any, z: Any) -> None:
    """Show the unit circle and what lies within :data:`FARTHEST` of zero; say what lies outside."""
    shown = z[np.abs(z) <= FARTHEST]
    low_x, high_x = min(-1.0, *shown.real, -1.0), max(1.0, *shown.real, 1.0)
    high_y = max(1.0, *np.abs(shown.imag), 1.0)
    gap = 0.06 * max(high_x - low_x, 2.0 * high_y)
    axes.set_xlim(low_x - gap, high_x + gap)
    axes.set_ylim(-high_y - gap, high_y + gap)
    axes.set_aspect("equal")
    axes.set_xlabel(f"real part of {label('mu')}")
    axes.set_ylabel(f"imaginary part of {label('mu')}")
    if len(shown) < len(z):
        text = f"{len(z) - len(shown)} outside, up to modulus {np.max(np.abs(z)):.3g}"
        axes.text(0.02, 0.98, text, transform=axes.transAxes, va="top", fontsize=8)
