"""Zeros of event functions within a step, found on the continuous extension and located to rounding.

Along a step an event function is taken as the polynomial of degree 8 through nine of its values, halving the step until
two more values agree with it. In Bernstein form a polynomial has no more zeros in an interval than its coefficients
change sign; halving (de Casteljau) until each part has one change or none finds every crossing that the polynomial
shows, a double one within a step too.

Reference: Farouki, The Bernstein polynomial basis: a centennial retrospective, Comput. Aided Geom. Design 29 (2012),
sections 3 and 6.
"""

from __future__ import annotations

import math
from enum import IntEnum
from math import inf

import numpy as np
from numpy.typing import NDArray

from pddecont.native.arrays import Floats
from pddecont.native.calls import offset
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_functions import evaluate_event, evaluate_event_slope, slope_rounding
from pddecont.native.integrator.history import interpolate_state
from pddecont.native.integrator.places import MODE, UNRESOLVED
from pddecont.native.integrator.ring import time_tolerance

# The degree of the continuous extension is 7; an event function that is a product or a root of states needs more.
DEGREE = 8
# Chebyshev's points of the second kind, where interpolation is well conditioned.
NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
# Two more places, away from the nodes and in no simple ratio to them.
CHECKS = np.array([0.3183, 0.8211])
# A polynomial is the function if it misses it at the checks by so little relative to its largest value, or by so many
# of the relative errors of a step; it is something else if it misses it by more than UNLIKE.
RESOLVED, RESOLVED_ERRORS, UNLIKE = 1e-10, 10.0, 1e-3
# Its signs are right too where its coefficients have one sign and it misses the function by less than this part of
# them.
NO_ZERO = 0.1
# Between its nodes a polynomial leaves their range by no more than the Lebesgue constant allows, 2.1 for these nine:
# values whose mean is farther from zero than so many half widths of their range have no zero between them.
FAR = 4.0
# A step is halved so often at most; then a step of the integration is too long.
MAX_HALVINGS = 6
# A zero is known to rounding after so many halvings of an interval (2^-40 of a step), and is located from there.
MAX_SPLITS = 40
# Evaluations for one zero: by regula falsi, which needs about ten, then by halving until rounding ends it.
MAX_SECANTS, MAX_EVALUATIONS = 60, 200
# Just after an event the sign of the function is looked for as near as 2^-60 of an interval, and a zero of the
# polynomial is halved as often.
NEAREST = 60
# What rounding in the values at the nodes makes of the coefficients where they are divided by the distance from a zero,
# in parts of what may be zero to rounding: the sum of a row of TO_BERNSTEIN is 184 at most, dividing takes a factor of
# 8, and what may be zero to rounding is some 50 roundings.
MAGNIFIED = 30.0
# Where a step ends a function may be on its zero if it is smaller than this part of what it was; it goes through if its
# slope carries it this many times as far as it may be from zero by rounding before its curvature turns it round.
END, SURE = 1e-3, 8.0
# Where between two zeros of a polynomial the function is looked at, to see whether it is beyond rounding there.
INSIDE = np.array([1.0, 0.5, 0.75, 0.25, 0.875, 0.125])
N_INSIDE = len(INSIDE)
# A zero is located to this part of the tolerance of times.
PART_OF_TOLERANCE = 64.0
# Rows of Workspace.bernstein have ten numbers: the coefficients, the values at the nodes, a stack of polynomials, and
# two rows to halve one with. Workspace.stack has 64 rows: 32 for intervals of the step, 32 for those of a polynomial.
ROW, SPARE_LEFT, SPARE_RIGHT = 10, 62, 63
SECOND_STACK = 32
# Polynomials that may wait on the stack; more zeros than that in a part of a step are located as if they were one.
MAX_WAITING = 26


class Fit(IntEnum):
    """How an event function on an interval compares with the polynomial through its values at the nodes."""

    FAR_FROM_ZERO = 0  # it has no zero there, whatever it is
    RESOLVED = 1
    CLOSE = 2  # not resolved, but nearly
    UNLIKE = 3
    ZERO = 4  # it is zero to rounding all over it


def _bernstein(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Bernstein polynomials of degree DEGREE at points ``x``, shape (n_points, DEGREE + 1)."""
    basis = [math.comb(DEGREE, k) * x**k * (1.0 - x) ** (DEGREE - k) for k in range(DEGREE + 1)]
    return np.stack(basis, axis=-1)


TO_BERNSTEIN = np.ascontiguousarray(np.linalg.inv(_bernstein(NODES)))
# The second derivative at 1 of the polynomial through values at the nodes.
CURVATURE_AT_END = DEGREE * (DEGREE - 1) * (TO_BERNSTEIN[-1] - 2.0 * TO_BERNSTEIN[-2] + TO_BERNSTEIN[-3])
AT_CHECKS = np.ascontiguousarray(_bernstein(CHECKS))


def _evaluate_in_step(c: Core, event: int, t: float, h: float, s: float) -> float:
    """Return the value of an event function at ``s`` in [0, 1] of the present step."""
    y = offset(c.trial, 2 * c.dimension)
    interpolate_state(c, s, y, c.n_full if c.reads[event] == 1 else c.n)
    return evaluate_event(c, event, t + s * h, y)


def find_first_crossing(
    c: Core, event: int, direction: int, t: float, h: float, side: int, residue: float
) -> tuple[float, int]:
    """Return where in a step an event function first crosses its zero in a direction, and its sign at the end.

    The place is in [0, 1], or -1 if there is none; direction 0 is any. A function has crossed when it is on the other
    side by more than rounding: until then its sign is what it was. ``side`` is the sign that it had when the step
    began; 0 says that only the flow can tell it, by the first derivative that is not zero. ``residue`` is how far from
    zero the function may be at the start, beyond rounding, and still be on its zero.
    """
    stack = c.stack
    top = 0
    stack[0], stack[1], stack[2] = 0.0, 1.0, 0.0
    before = side
    while top >= 0:
        a, b, depth = stack[4 * top], stack[4 * top + 1], stack[4 * top + 2]
        top -= 1
        fit, on_surface, rounding = _interpolate(c, event, t, h, a, b, residue)
        if fit == Fit.ZERO:
            continue
        if fit == Fit.FAR_FROM_ZERO:
            after = 1 if c.bernstein[ROW] > 0.0 else -1
            if before * after < 0 and direction * after >= 0:
                return a, after
            before = after
            continue
        if before == 0 and on_surface and c.bernstein[0] != 0.0:
            before = 1 if c.bernstein[0] > 0.0 else -1
        if fit == Fit.UNLIKE and depth >= MAX_HALVINGS:
            c.count[UNRESOLVED] = 1
        if (fit == Fit.CLOSE or fit == Fit.UNLIKE) and depth < MAX_HALVINGS:
            middle = 0.5 * (a + b)
            _push(stack, top + 1, middle, b, depth + 1.0)
            _push(stack, top + 2, a, middle, depth + 1.0)
            top += 2
            continue
        found, before = _find_crossing(c, event, direction, t, h, a, b, before, on_surface, rounding)
        if found >= 0.0:
            return found, before
        if b == 1.0 and before != 0 and direction * before <= 0:
            found = _find_crossing_at_end(c, event, before, t, h, b - a)
            if found >= 0.0:
                return found, -before
    return -1.0, before


def _interpolate(
    c: Core, event: int, t: float, h: float, a: float, b: float, residue: float
) -> tuple[int, bool, float]:
    """Write the Bernstein coefficients of an event function on [a, b] to ``c.bernstein``; return how well they fit.

    Where a step begins on the zero of the function, the coefficients are those of the function divided by the distance
    from it, one fewer. Returned are also whether it does, and how far from zero it is zero to rounding there.
    """
    coefficients, nodes = c.bernstein, offset(c.bernstein, ROW)
    low, high = inf, -inf
    for i in range(DEGREE + 1):
        nodes[i] = _evaluate_in_step(c, event, t, h, a + (b - a) * NODES[i])
        low, high = min(low, nodes[i]), max(high, nodes[i])
    largest = max(abs(low), abs(high))
    if abs(low + high) > FAR * (high - low) and (a > 0.0 or residue == 0.0 or abs(nodes[0]) > residue):
        return Fit.FAR_FROM_ZERO, False, 0.0
    on_surface, rounding, slope = False, 0.0, 0.0
    if a == 0.0:
        slope, rounding = evaluate_event_slope(c, event, c.count[MODE], t, c.y)
        rounding = max(rounding, residue)
        if abs(slope) <= slope_rounding(c, event):
            slope = 0.0
        on_surface = abs(nodes[0]) <= rounding
        if largest <= rounding:
            return Fit.ZERO, on_surface, rounding
    if on_surface:
        nodes[0] = 0.0
    for i in range(DEGREE + 1):
        total = 0.0
        for j in range(DEGREE + 1):
            total += TO_BERNSTEIN[i][j] * nodes[j]
        coefficients[i] = total
    worst = 0.0
    for i in range(2):
        total = 0.0
        for j in range(DEGREE + 1):
            total += AT_CHECKS[i][j] * coefficients[j]
        worst = max(worst, abs(total - _evaluate_in_step(c, event, t, h, a + (b - a) * CHECKS[i])))
    # The ends are known exactly, whatever the matrix's rounding.
    coefficients[0], coefficients[DEGREE] = nodes[0], nodes[DEGREE]
    nearest = inf
    sign = 0
    for i in range(DEGREE + 1):
        nearest = min(nearest, abs(coefficients[i]))
        here = 1 if coefficients[i] > 0.0 else -1
        if i > 0 and here != sign:
            nearest = 0.0
        sign = here
    if on_surface:
        for i in range(DEGREE):
            coefficients[i] = coefficients[i + 1] * DEGREE / (i + 1)
        # The slope at the zero itself is known without the rounding of the polynomial: a motion may leave tangentially
        # or hop by little.
        coefficients[0] = slope * h * (b - a)
    if worst <= max(RESOLVED, RESOLVED_ERRORS * c.rtol) * largest or worst < NO_ZERO * nearest:
        return Fit.RESOLVED, on_surface, rounding
    return Fit.UNLIKE if worst > UNLIKE * largest else Fit.CLOSE, on_surface, rounding


def _find_crossing(
    c: Core,
    event: int,
    direction: int,
    t: float,
    h: float,
    a: float,
    b: float,
    before: int,
    on_surface: bool,
    rounding: float,
) -> tuple[float, int]:
    """Return the first crossing within [a, b] of the polynomial in ``c.bernstein`` (-1: none) and the sign after it.

    ``before`` is the sign at ``a``, 0 where the first coefficient beyond ``rounding`` tells it.
    """
    degree = DEGREE - 1 if on_surface else DEGREE
    bounds = offset(c.stack, 4 * SECOND_STACK)
    spare_left, spare_right = offset(c.bernstein, SPARE_LEFT * ROW), offset(c.bernstein, SPARE_RIGHT * ROW)
    for i in range(degree + 1):
        c.bernstein[2 * ROW + i] = c.bernstein[i]
    top = 0
    _push(bounds, 0, 0.0, 1.0, 0.0)
    while top >= 0:
        row, below = offset(c.bernstein, (2 + top) * ROW), offset(c.bernstein, (3 + top) * ROW)
        left, right, splits = bounds[4 * top], bounds[4 * top + 1], bounds[4 * top + 2]
        changes, sign = 0, before
        for i in range(degree + 1):
            here = 1 if row[i] > 0.0 else -1 if row[i] < 0.0 else 0
            if here != 0 and (before != 0 or abs(row[i]) > MAGNIFIED * rounding):
                if sign != 0 and here != sign:
                    changes += 1
                sign = here
                if before == 0:
                    before = here
        last = row[degree]
        top -= 1
        if changes == 0:
            before = sign
        elif changes == 1 or splits >= MAX_SPLITS or top > MAX_WAITING:
            after = 1 if last > 0.0 else -1 if last < 0.0 else before
            # A polynomial, or rounding, may show what the function does not do.
            beyond = _find_beyond_rounding(c, event, after, t, h, a, b, left, right) if after != before else -1.0
            if beyond >= 0.0:
                if direction == 0 or direction == after:
                    return _locate(c, event, t, h, a, b, left, beyond, before, degree, rounding), after
                before = after
        else:
            # De Casteljau at the middle; the left part goes on top of the stack, to come first.
            for level in range(degree + 1):
                spare_left[level], spare_right[degree - level] = row[0], row[degree - level]
                for i in range(degree - level):
                    row[i] = 0.5 * (row[i] + row[i + 1])
            for i in range(degree + 1):
                row[i], below[i] = spare_right[i], spare_left[i]
            middle = 0.5 * (left + right)
            _push(bounds, top + 1, middle, right, splits + 1.0)
            _push(bounds, top + 2, left, middle, splits + 1.0)
            top += 2
    return -1.0, before


def _push(stack: Floats, place: int, left: float, right: float, depth: float) -> None:
    stack[4 * place], stack[4 * place + 1], stack[4 * place + 2] = left, right, depth


def _find_beyond_rounding(
    c: Core, event: int, side: int, t: float, h: float, a: float, b: float, low: float, high: float
) -> float:
    """Return where in the part [low, high] of [a, b] an event function is on a side of its zero by more than rounding.

    It is looked for at the end first, then inside, as the function may be on its zero there again; -1 if nowhere.
    """
    y = offset(c.trial, 2 * c.dimension)
    for i in range(N_INSIDE):
        place = low + (high - low) * INSIDE[i]
        s = a + (b - a) * place
        value = _evaluate_in_step(c, event, t, h, s)
        if value * side <= 0.0:
            continue
        interpolate_state(c, s, y, c.dimension)
        _, size = evaluate_event_slope(c, event, c.count[MODE], t + s * h, y)
        if value * side > size:
            return place
    return -1.0


def _find_crossing_at_end(c: Core, event: int, before: int, t: float, h: float, width: float) -> float:
    """Return where an event function, zero to rounding at the end of a step, leaves side ``before``; -1 if it does not.

    It does if it is past its zero, or as near to it as zeros are located, and if its slope carries it farther than
    rounding before its curvature may turn it round: that of the polynomial through its values at the nodes in the last
    part of the step, ``width`` wide.
    """
    nodes = offset(c.bernstein, ROW)
    if abs(nodes[DEGREE]) > END * abs(nodes[0]):
        return -1.0
    value = _evaluate_in_step(c, event, t, h, 1.0)
    y = offset(c.trial, 2 * c.dimension)
    interpolate_state(c, 1.0, y, c.dimension)
    slope, size = evaluate_event_slope(c, event, c.count[MODE], t + h, y)
    curvature = 0.0
    for i in range(DEGREE + 1):
        curvature += CURVATURE_AT_END[i] * nodes[i]
    curvature /= (h * width) ** 2
    near = abs(slope) * time_tolerance(t + h) / PART_OF_TOLERANCE
    if value * before > near or value * before < -size or slope * before >= 0.0:
        return -1.0
    if slope * slope <= SURE * abs(curvature) * size:
        return -1.0
    return min(1.0, 1.0 - value / (slope * h))


def _find_zero_of_polynomial(c: Core, left: float, right: float, before: int, degree: int) -> float:
    """Return where the polynomial in ``c.bernstein`` leaves the sign ``before`` in [left, right], by halving."""
    values = offset(c.bernstein, SPARE_LEFT * ROW)
    for _ in range(NEAREST):
        middle = 0.5 * (left + right)
        for i in range(degree + 1):
            values[i] = c.bernstein[i]
        for level in range(degree):
            for i in range(degree - level):
                values[i] = (1.0 - middle) * values[i] + middle * values[i + 1]
        if values[0] * before > 0.0:
            left = middle
        else:
            right = middle
    return right


def _locate(
    c: Core,
    event: int,
    t: float,
    h: float,
    a: float,
    b: float,
    low: float,
    high: float,
    before: int,
    degree: int,
    rounding: float,
) -> float:
    """Return where an event function leaves the sign ``before`` in the part [low, high] of [a, b].

    It is found by the Illinois form of regula falsi, then by halving.
    """
    left, right = a + (b - a) * low, a + (b - a) * high
    f_right = _evaluate_in_step(c, event, t, h, right)
    if f_right == 0.0:
        return right
    f_left = _evaluate_in_step(c, event, t, h, left)
    # Just after an event the function is zero to rounding at the left end, and its sign there means nothing: look for a
    # time at which it is on its side. Where there is none the polynomial, whose slope is known, says where it returns.
    if f_left * before <= (rounding if left == 0.0 else 0.0):
        width = right - left
        f_left = 0.0
        for k in range(1, NEAREST + 1):
            trial = left + width * 2.0**-k
            value = _evaluate_in_step(c, event, t, h, trial)
            if value * before > (rounding if left == 0.0 else 0.0):
                left, f_left = trial, value
                break
        if f_left == 0.0:
            return a + (b - a) * _find_zero_of_polynomial(c, low, high, before, degree)
    smallest = time_tolerance(t) / abs(h) / PART_OF_TOLERANCE
    kept = 0
    for k in range(MAX_EVALUATIONS):
        if right - left <= smallest:
            break
        if k < MAX_SECANTS:
            s = (left * f_right - right * f_left) / (f_right - f_left)
            if not left < s < right:
                s = 0.5 * (left + right)
        else:
            s = 0.5 * (left + right)
        if s <= left or s >= right:
            break
        value = _evaluate_in_step(c, event, t, h, s)
        if value == 0.0:
            return s
        if value * before > 0.0:
            left, f_left = s, value
            if kept == 1:
                f_right *= 0.5
            kept = 1
        else:
            right, f_right = s, value
            if kept == -1:
                f_left *= 0.5
            kept = -1
    return right
