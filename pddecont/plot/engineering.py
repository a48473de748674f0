"""Numbers on axes in engineering form: a power of ten stands once, at the axis's end, and is a multiple of three."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.ticker import Formatter

# Numbers are written out while the largest on the axis is within these limits.
LEAST, MOST = 1e-2, 1e5
# Of digits after the point; axes that show a smaller part of their numbers have an offset, as matplotlib writes it.
MAX_DECIMALS = 6


def use_engineering_form(figure: Figure) -> None:
    """Give axes with matplotlib's own numbers this program's, but those so far from zero that they have an offset."""
    from matplotlib.ticker import ScalarFormatter

    formatter = make_formatter()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis, *([axes.zaxis] if hasattr(axes, "zaxis") else [])):
            low, high = axis.get_view_interval()
            narrow = high - low < 10.0**-MAX_DECIMALS * max(abs(low), abs(high))
            if type(axis.get_major_formatter()) is ScalarFormatter and axis.get_scale() == "linear" and not narrow:
                axis.set_major_formatter(formatter())


def make_formatter() -> type[Formatter]:
    """Return the class of formatters; it is made when it is needed, for matplotlib is loaded late."""
    from matplotlib.ticker import Formatter

    class EngineeringFormatter(Formatter):
        """Numbers as few digits tell them apart, in a power of a thousand."""

        def __init__(self) -> None:
            self.exponent, self.decimals = 0, 0

        def set_locs(self, locs: list[float]) -> None:
            """Choose power and digits for the ticks at ``locs``."""
            super().set_locs(locs)
            assert self.axis is not None
            low, high = sorted(self.axis.get_view_interval())
            shown = [place for place in locs if low <= place <= high] or list(locs)
            self.exponent = find_exponent(shown)
            self.decimals = count_decimals([place / 10.0**self.exponent for place in shown])

        def __call__(self, x: float, pos: int | None = None) -> str:
            text = f"{x / 10.0**self.exponent:.{self.decimals}f}"
            # Of what is nothing but rounding no sign is left.
            return self.fix_minus(text.lstrip("-") if float(text) == 0.0 else text)

        def get_offset(self) -> str:
            """Return the power of ten."""
            return f"$\\times\\mathdefault{{10^{{{self.exponent}}}}}$" if self.exponent else ""

    return EngineeringFormatter


def find_exponent(values: Sequence[float]) -> int:
    """Return the power of ten, a multiple of three, that goes before numbers; 0 where they are written out."""
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    if largest == 0.0 or LEAST <= largest < MOST:
        return 0
    return 3 * math.floor(math.log10(largest * (1.0 + 1e-12)) / 3)


def count_decimals(values: Sequence[float]) -> int:
    """Return the least number of decimals with which numbers are what they are, but for rounding."""
    places = np.array([value for value in values if math.isfinite(value)], dtype=float)
    gap = float(np.min(np.diff(np.unique(places)), initial=np.inf))
    close = 1e-3 * (gap if math.isfinite(gap) else float(np.max(np.abs(places), initial=1.0)))
    fitting = (n for n in range(MAX_DECIMALS + 4) if np.all(np.abs(np.round(places, n) - places) <= close))
    return next(fitting, MAX_DECIMALS + 4)


def write_number(value: float) -> str:
    """Return a number with six digits for a title or a legend, its power of ten a multiple of three."""
    exponent = find_exponent([value])
    digits = f"{value / 10.0**exponent:.6g}".replace("-", "\N{MINUS SIGN}")
    return f"{digits} $\\cdot$ 10$^{{{exponent}}}$" if exponent else digits
