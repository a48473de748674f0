"""The functions of expressions over intervals: powers, exponentials, trigonometric and hyperbolic functions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pddecont.intervals.arithmetic import (
    Array,
    Bools,
    Interval,
    empty_where,
    invert,
    make_interval,
    make_point,
    replace_where,
    round_outwards,
    stack,
)

# A bound on the relative error of numpy's functions: glibc's is about 1 unit in the last place, that of vector code
# below 4. Near its zeros a trigonometric function has that error of 1.
ERROR = 8.0 * float(np.finfo(float).eps)
TINY = float(np.nextafter(0.0, 1.0))
# Turns are counted below this argument.
LARGE = 1e8
# What is added to the ends of an argument, in turns, when its turns are counted.
TURN_ERROR = 1e-7


def power(x: Interval, exponent: Interval) -> Interval:
    """Return x to a power; a whole number as a product, any other of numbers that are not negative."""
    if exponent.low.size == 1 and np.all(exponent.low == exponent.high):
        number = float(exponent.low.reshape(-1)[0])
        if number.is_integer():
            return raise_to(x, number)
        if number == 0.5:
            return sqrt(x)
    return _raise_positive(x, exponent)


def raise_to(x: Interval, n: float) -> Interval:
    """Return the power of a whole number ``n``."""
    if n == 0.0:
        one = np.where(x.is_empty, np.nan, 1.0)
        return Interval(one, one, x.sure)
    if n < 0.0:
        return invert(raise_to(x, -n))
    if n == 1.0:
        return x
    if n % 2.0:
        return _map_growing(lambda v: np.power(v, n), x)
    size = absolute(x)
    return _map_growing(np.square if n == 2.0 else lambda v: np.power(v, n), size, low=0.0)


def _raise_positive(x: Interval, exponent: Interval) -> Interval:
    """Return a power of numbers that are not negative; the whole line where a negative one may have one too."""
    strange = (x.low < 0.0) & (np.ceil(exponent.low) <= np.floor(exponent.high))
    x = _restrict(x, 0.0, np.inf)
    corners = [np.power(a, b) for a in (x.low, x.high) for b in (exponent.low, exponent.high)]
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    touches = (x.low == 0.0) & (exponent.low <= 0.0)
    sure = x.sure & exponent.sure & ~touches
    found = Interval(np.maximum(_widen(low, -1.0), 0.0), _widen(high, 1.0), sure)
    found = empty_where(x.is_empty | exponent.is_empty, found)
    low, high = np.where(strange, -np.inf, found.low), np.where(strange, np.inf, found.high)
    return Interval(low, high, found.sure & ~strange)


def sqrt(x: Interval) -> Interval:
    """Return the square root, which is rounded correctly."""
    x = _restrict(x, 0.0, np.inf)
    low, high = np.sqrt(x.low), np.sqrt(x.high)
    return Interval(round_outwards(low, -np.inf, low == 0.0), round_outwards(high, np.inf, high == 0.0), x.sure)


def absolute(x: Interval) -> Interval:
    """Return the absolute value."""
    low = np.where(x.low > 0.0, x.low, np.where(x.high < 0.0, -x.high, np.where(x.is_empty, np.nan, 0.0)))
    return Interval(low, x.magnitude, x.sure)


def sign(x: Interval) -> Interval:
    """Return the sign, which jumps at zero."""
    return Interval(np.sign(x.low), np.sign(x.high), x.sure & ~x.holds_zero)


def exp(x: Interval) -> Interval:
    """Return the exponential function."""
    return _map_growing(np.exp, x, low=0.0)


def log(x: Interval) -> Interval:
    """Return the logarithm."""
    x = _restrict(x, 0.0, np.inf)
    found = _map_growing(np.log, x)
    return empty_where(x.high == 0.0, Interval(found.low, found.high, found.sure & (x.low > 0.0)))


def sinh(x: Interval) -> Interval:
    """Return the hyperbolic sine."""
    return _map_growing(np.sinh, x)


def cosh(x: Interval) -> Interval:
    """Return the hyperbolic cosine."""
    return _map_growing(np.cosh, absolute(x), low=1.0)


def tanh(x: Interval) -> Interval:
    """Return the hyperbolic tangent."""
    return _map_growing(np.tanh, x, low=-1.0, high=1.0)


def atan(x: Interval) -> Interval:
    """Return the arc tangent."""
    return _map_growing(np.arctan, x, low=-_QUARTER, high=_QUARTER)


def asin(x: Interval) -> Interval:
    """Return the arc sine."""
    return _map_growing(np.arcsin, _restrict(x, -1.0, 1.0), low=-_QUARTER, high=_QUARTER)


def acos(x: Interval) -> Interval:
    """Return the arc cosine."""
    found = _map_growing(lambda v: -np.arccos(v), _restrict(x, -1.0, 1.0), low=-2.0 * _QUARTER, high=0.0)
    return -found


def sin(x: Interval) -> Interval:
    """Return the sine."""
    return _map_wave(np.sin, x, 0.25)


def cos(x: Interval) -> Interval:
    """Return the cosine."""
    return _map_wave(np.cos, x, 0.0)


def tan(x: Interval) -> Interval:
    """Return the tangent; the whole line where it has a pole inside."""
    found = _map_growing(np.tan, x)
    near = Interval(found.low - ERROR, found.high + ERROR, found.sure)
    return replace_where(_holds_turn(x, 0.5, np.pi), -np.inf, np.inf, near)


def atan2(y: Interval, x: Interval) -> Interval:
    """Return the angle of a point (x, y); any where the box touches the half line on which it jumps."""
    corners = stack([make_point(np.arctan2(b, a)) for b in (y.low, y.high) for a in (x.low, x.high)])
    low, high = _widen(corners.low.min(axis=0), -1.0), _widen(corners.high.max(axis=0), 1.0)
    return replace_where(
        y.holds_zero & (x.low <= 0.0), -2.0 * _QUARTER, 2.0 * _QUARTER, Interval(low, high, x.sure & y.sure)
    )


# A number just above a quarter of a turn.
_QUARTER = float(np.nextafter(np.pi / 2.0, 2.0))


def _restrict(x: Interval, low: float, high: float) -> Interval:
    """Return the part of intervals that lies in a function's domain; where that is not all they are not sure."""
    inside = Interval(np.maximum(x.low, low), np.minimum(x.high, high), x.sure & (x.low >= low) & (x.high <= high))
    return empty_where((x.high < low) | (x.low > high), inside)


def _map_growing(
    function: Callable[[Array], Array], x: Interval, low: float = -np.inf, high: float = np.inf
) -> Interval:
    """Return the values of a function that grows, between its bounds; where it is zero at zero it is so exactly."""
    below, above = function(x.low), function(x.high)
    below = _widen(below, -1.0, (x.low == 0.0) & (below == 0.0))
    above = _widen(above, 1.0, (x.high == 0.0) & (above == 0.0))
    return Interval(np.maximum(below, low), np.minimum(above, high), x.sure)


def _widen(values: Array, way: float, exact: Bools | bool = False) -> Array:
    """Return a function's values moved outwards by their error; those that are ``exact`` stay."""
    moved = values + way * (ERROR * np.abs(values) + TINY)
    moved = np.where(np.isinf(values), np.nextafter(values, way * np.inf), moved)
    return np.where(exact, values, moved)


def _map_wave(function: Callable[[Array], Array], x: Interval, peak: float) -> Interval:
    """Return a sine or cosine whose peaks lie at whole turns and ``peak``."""
    ends = function(x.low), function(x.high)
    low, high = np.minimum(*ends) - ERROR, np.maximum(*ends) + ERROR
    zero = (x.low == 0.0) & (x.high == 0.0) & (ends[0] == 0.0)
    low, high = np.where(zero, 0.0, low), np.where(zero, 0.0, high)
    low = np.where(_holds_turn(x, peak + 0.5, 2.0 * np.pi), -1.0, np.maximum(low, -1.0))
    high = np.where(_holds_turn(x, peak, 2.0 * np.pi), 1.0, np.minimum(high, 1.0))
    return Interval(np.where(x.is_empty, np.nan, low), np.where(x.is_empty, np.nan, high), x.sure)


def _holds_turn(x: Interval, shift: float, turn: float) -> Bools:
    """Return whether intervals may hold a number that is ``shift`` turns and a whole number of turns."""
    low, high = x.low / turn - shift - TURN_ERROR, x.high / turn - shift + TURN_ERROR
    return (np.ceil(low) <= np.floor(high)) | (x.magnitude > LARGE)


def make_number(value: float, *, exact: bool) -> Interval:
    """Return the interval of a number that stands rounded to the nearest double, shape (1,)."""
    at = np.array([value])
    return make_point(at) if exact else make_interval(np.nextafter(at, -np.inf), np.nextafter(at, np.inf))
