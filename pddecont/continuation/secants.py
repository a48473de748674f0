"""The zero of a function whose values are dear: secants, kept between two places where its signs differ."""

from __future__ import annotations

from collections.abc import Callable

# Evaluations at most: twice as many as halving alone needs for any tolerance above rounding.
MAX_EVALUATIONS = 110
# A secant after which more than this part of the value is left is followed by halving.
LEFT = 0.5
# A secant that moves the place by less than this part of the way leaves an error that is smaller by far: rounding.
LAST = 1e-10


def find_zero_between(
    value: Callable[[float], float], low: float, high: float, f_low: float, f_high: float, tol: float
) -> tuple[float, float]:
    """Return where between two places a function is zero, and its value there.

    It is the last place of which the value was taken, as soon as another secant would move it by no more than ``tol``,
    or the last one was so short that only rounding is left: no value is spent on a bracket around it. Where the
    function jumps through zero it lies at the jump.
    """
    here, f_here, before, f_before = low, f_low, high, f_high
    if abs(f_high) < abs(f_low):
        here, f_here, before, f_before = before, f_before, here, f_here
    falls, least = True, LAST * (high - low)
    for _ in range(MAX_EVALUATIONS):
        if f_here == 0.0 or high - low <= tol:
            break
        secant = here if f_here == f_before else here - f_here * (here - before) / (f_here - f_before)
        if f_here != f_before and abs(secant - here) <= tol:
            break
        by_secant = falls and low < secant < high
        before, f_before, here = here, f_here, secant if by_secant else 0.5 * (low + high)
        f_here = value(here)
        if (f_here > 0.0) == (f_low > 0.0):
            low = here
        else:
            high = here
        falls = not by_secant or abs(f_here) <= LEFT * abs(f_before)
        if by_secant and falls and abs(here - before) <= least:
            break
    return here, f_here
