"""The ring of past steps: finding one, and evaluating its continuous extension; before them comes the history."""

from __future__ import annotations

from pddecont.native.arrays import Floats
from pddecont.native.calls import call
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.places import CONSTANT, FIRST, N_COEFFICIENTS, USED

# Two times closer than so many units in the last place are one: enough for the rounding of sums of delays.
TIME_UNITS = 32 * 2.220446049250313e-16


def time_tolerance(t: float) -> float:
    """Return how close two times may be and still be one."""
    return TIME_UNITS * max(1.0, abs(t))


def find_step_before(c: Core, t: float, guess: int) -> int:
    """Return the number of the last step that begins at ``t`` or before, found by walking from a ``guess``."""
    first, end = c.count[FIRST], c.count[FIRST] + c.count[USED]
    number = min(max(guess, first), end - 1)
    while number + 1 < end and c.past_time[(number + 1) & c.mask] <= t:
        number += 1
    while number > first and c.past_time[number & c.mask] > t:
        number -= 1
    return number


def evaluate_extension(value: float, coefficients: Floats, row: int, s: float) -> float:
    """Return the value of a continuous extension at ``s`` in [0, 1].

    ``coefficients`` points to the first of them; the next are ``row`` numbers apart.

    Reference: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.6.
    """
    r, y = 1.0 - s, coefficients[6 * row] * s
    y = (y + coefficients[5 * row]) * r
    y = (y + coefficients[4 * row]) * s
    y = (y + coefficients[3 * row]) * r
    y = (y + coefficients[2 * row]) * s
    y = (y + coefficients[row]) * r
    return value + (y + coefficients[0]) * s


def evaluate_extension_slope(coefficients: Floats, row: int, s: float) -> float:
    """Return the derivative of a continuous extension in ``s``."""
    y, slope = 0.0, 0.0
    for i in range(N_COEFFICIENTS - 1, -1, -1):
        y += coefficients[i * row]
        if i % 2 == 0:
            slope = slope * s + y
            y *= s
        else:
            slope = slope * (1.0 - s) - y
            y *= 1.0 - s
    return slope


def evaluate_extension_derivative(value: float, coefficients: Floats, row: int, s: float, order: int) -> float:
    """Return the derivative of an order from 0 to 3 of a continuous extension in ``s``; arguments as above.

    The recursion of :func:`evaluate_extension`, differentiated by the product rule.
    """
    y, first, second, third = 0.0, 0.0, 0.0, 0.0
    for i in range(N_COEFFICIENTS - 1, -1, -1):
        factor, slope = (s, 1.0) if i % 2 == 0 else (1.0 - s, -1.0)
        y += coefficients[i * row]
        third = third * factor + 3.0 * second * slope
        second = second * factor + 2.0 * first * slope
        first = first * factor + y * slope
        y *= factor
    if order == 0:
        return value + y
    return first if order == 1 else second if order == 2 else third


def evaluate_history(c: Core, order: int, t: float, state: int) -> float:
    """Return a state of the history before the start, or its derivative of an order."""
    if c.count[CONSTANT] == 1:
        return 0.0 if order > 0 else c.constant[state]
    c.past_trial[state] = 0.0
    call(c.history, order, t, c.constant, c.constant, c.p, c.past_trial)
    return c.past_trial[state]
