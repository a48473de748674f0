"""Arrays of intervals: sums and products that hold every value of the exact ones.

Ends are rounded outwards. An interval holds the values of a function over a box wherever the function is defined there;
``sure`` says that it is defined and continuous all over the box (the decoration "dac" of IEEE 1788). Where the function
is defined nowhere its interval is empty: both ends are NaN.

References: IEEE 1788-2015, Standard for Interval Arithmetic; Moore, Kearfott, Cloud, Introduction to Interval Analysis
(2009), doi:10.1137/1.9780898717716.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Interval:
    """Intervals from ``low`` to ``high``, and whether they are ``sure``: three arrays of one shape."""

    low: Array
    high: Array
    sure: Bools

    @property
    def ends(self) -> tuple[Array, ...]:
        """Both ends; one for intervals that were made of numbers."""
        return (self.low,) if self.low is self.high else (self.low, self.high)

    @property
    def middle(self) -> Array:
        """A number inside each interval; NaN in those without bounds."""
        return np.clip(0.5 * self.low + 0.5 * self.high, self.low, self.high)

    @property
    def magnitude(self) -> Array:
        """The largest absolute value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def holds_zero(self) -> Bools:
        """Whether zero lies in it; never in an empty one."""
        return (self.low <= 0.0) & (self.high >= 0.0)

    @property
    def is_empty(self) -> Bools:
        """Whether nothing lies in it."""
        return np.isnan(self.low)

    @property
    def is_bounded(self) -> Bools:
        """Whether both ends are finite."""
        return np.isfinite(self.low) & np.isfinite(self.high)

    def __getitem__(self, place: Any) -> Interval:
        return Interval(self.low[place], self.high[place], self.sure[place])

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low, self.sure)

    def __add__(self, other: Interval) -> Interval:
        return Interval(_add(self.low, other.low, -np.inf), _add(self.high, other.high, np.inf), self.sure & other.sure)

    def __sub__(self, other: Interval) -> Interval:
        return self + (-other)

    def __mul__(self, other: Interval) -> Interval:
        made = [_multiply(a, b) for a in self.ends for b in other.ends]
        low, high = (reduce(pick, (product for product, _ in made)) for pick in (np.minimum, np.maximum))
        exact = ~reduce(np.logical_or, (lost for _, lost in made))
        return Interval(
            round_outwards(low, -np.inf, exact & (low == 0.0)),
            round_outwards(high, np.inf, exact & (high == 0.0)),
            self.sure & other.sure,
        )


def make_point(values: Array) -> Interval:
    """Return the intervals that hold one number each."""
    return make_interval(values, values)


def make_interval(low: Array, high: Array) -> Interval:
    """Return intervals with these ends."""
    return Interval(low, high, np.ones(np.shape(low), dtype=bool))


def stack(parts: list[Interval], axis: int = 0) -> Interval:
    """Return intervals of one shape in one array, along a new axis."""
    return Interval(*(np.stack([getattr(part, name) for part in parts], axis) for name in ("low", "high", "sure")))


def replace_where(where: Bools, low: Array | float, high: Array | float, other: Interval) -> Interval:
    """Return intervals from ``low`` to ``high``, not sure, where a condition holds, and others elsewhere.

    What is empty stays so.
    """
    where = where & ~other.is_empty
    return Interval(np.where(where, low, other.low), np.where(where, high, other.high), other.sure & ~where)


def empty_where(where: Bools, other: Interval) -> Interval:
    """Return empty intervals where a condition holds, and others elsewhere."""
    return Interval(np.where(where, np.nan, other.low), np.where(where, np.nan, other.high), other.sure & ~where)


def invert(x: Interval) -> Interval:
    """Return 1/x: a half line where zero is an end, the whole line where it lies inside."""
    low = np.where(x.high == 0.0, -np.inf, round_outwards(1.0 / x.high, -np.inf))
    high = np.where(x.low == 0.0, np.inf, round_outwards(1.0 / x.low, np.inf))
    found = replace_where((x.low < 0.0) & (x.high > 0.0), -np.inf, np.inf, Interval(low, high, x.sure & ~x.holds_zero))
    return empty_where((x.low == 0.0) & (x.high == 0.0), found)


def round_outwards(values: Array, way: float, exact: Bools | bool = False) -> Array:
    """Return rounded numbers moved to their neighbours towards ``way``; those that are ``exact`` stay."""
    return np.where(exact, values, np.nextafter(values, way))


def _add(a: Array, b: Array, way: float) -> Array:
    """Return a sum rounded outwards; Knuth's error term says whether it is exact."""
    total = a + b
    part = total - a
    return round_outwards(total, way, (a - (total - part)) + (b - part) == 0.0)


def _multiply(a: Array, b: Array) -> tuple[Array, Bools]:
    """Return a product of ends, zero times infinity being zero, and whether a product that is not zero became so."""
    product = a * b
    zero = (a == 0.0) | (b == 0.0)
    product = np.where(zero & ~np.isnan(a) & ~np.isnan(b), 0.0, product)
    return product, (product == 0.0) & ~zero
