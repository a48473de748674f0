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

import numpy as np

from pddecont.simulate.integrator.calls import internal, offset
from pddecont.simulate.integrator.event_functions import evaluate_event, evaluate_event_slope
from pddecont.simulate.integrator.history import interpolate_state, time_tolerance
from pddecont.simulate.integrator.state import MODE, UNRESOLVED

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
# A function that was zero where a step begins has jumped if it is larger there than this part of its values later on.
JUMPED = 1e-9
# Evaluations for one zero: by regula falsi, which needs about ten, then by halving until rounding ends it.
MAX_SECANTS, MAX_EVALUATIONS = 60, 200
# Just after an event the sign of the function is looked for as near as 2^-60 of an interval.
NEAREST = 60
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


def _bernstein(x):
    """Return the Bernstein polynomials of degree DEGREE at points ``x``, shape (n_points, DEGREE + 1)."""
    basis = [math.comb(DEGREE, k) * x**k * (1.0 - x) ** (DEGREE - k) for k in range(DEGREE + 1)]
    return np.stack(basis, axis=-1)


TO_BERNSTEIN = np.ascontiguousarray(np.linalg.inv(_bernstein(NODES)))
AT_CHECKS = np.ascontiguousarray(_bernstein(CHECKS))


@internal
def _evaluate_in_step(c, event, t, h, s):
    """Return the value of an event function at ``s`` in [0, 1] of the present step."""
    y = offset(c.trial, 2 * c.dimension)
    interpolate_state(c, s, y, c.n_full if c.reads[event] == 1 else c.n)
    return evaluate_event(c, event, t + s * h, y)


@internal
def find_first_crossing(c, event, direction, t, h, side):
    """Return where in a step an event function first crosses its zero in a direction, and its sign at the end.

    The place is in [0, 1], or -1 if there is none; direction 0 is any. ``side`` is the sign that the function had when
    the step began; 0 says that the step begins on its zero, which is then no crossing.
    """
    stack = c.stack
    top = 0
    stack[0], stack[1], stack[2] = 0.0, 1.0, 0.0
    before = side
    while top >= 0:
        a, b, depth = stack[4 * top], stack[4 * top + 1], stack[4 * top + 2]
        top -= 1
        on_surface = a == 0.0 and before == 0 and not _has_jumped(c, event, t, h)
        fit = _interpolate(c, event, t, h, a, b, on_surface)
        if fit == Fit.FAR_FROM_ZERO:
            after = 1 if c.bernstein[ROW] > 0.0 else -1
            if before * after < 0 and direction * after >= 0:
                return a, after
            before = after
            continue
        if fit == Fit.UNLIKE and depth >= MAX_HALVINGS:
            c.count[UNRESOLVED] = 1
        if (fit == Fit.CLOSE or fit == Fit.UNLIKE) and depth < MAX_HALVINGS:
            middle = 0.5 * (a + b)
            _push(stack, top + 1, middle, b, depth + 1.0)
            _push(stack, top + 2, a, middle, depth + 1.0)
            top += 2
            continue
        found, before = _find_crossing(c, event, direction, t, h, a, b, before, on_surface)
        if found >= 0.0:
            return found, before
    return -1.0, before


@internal
def _has_jumped(c, event, t, h):
    """Return whether an event function that was zero is not zero any more, as a delayed value jumps."""
    first = abs(_evaluate_in_step(c, event, t, h, 0.0))
    later = first + abs(_evaluate_in_step(c, event, t, h, 0.5)) + abs(_evaluate_in_step(c, event, t, h, 1.0))
    return first > JUMPED * later


@internal
def _interpolate(c, event, t, h, a, b, on_surface):
    """Write the Bernstein coefficients of an event function on [a, b] to ``c.bernstein``; return how well they fit.

    Where it begins on its zero the coefficients are those of the function divided by the distance from it, one fewer.
    """
    coefficients, nodes = c.bernstein, offset(c.bernstein, ROW)
    low, high = math.inf, -math.inf
    for i in range(DEGREE + 1):
        nodes[i] = _evaluate_in_step(c, event, t, h, a + (b - a) * NODES[i])
        low, high = min(low, nodes[i]), max(high, nodes[i])
    largest = max(abs(low), abs(high))
    if not on_surface and abs(low + high) > FAR * (high - low):
        return Fit.FAR_FROM_ZERO
    if on_surface:
        nodes[0] = 0.0
    for i in range(DEGREE + 1):
        total = 0.0
        for j in range(DEGREE + 1):
            total += TO_BERNSTEIN[i, j] * nodes[j]
        coefficients[i] = total
    worst = 0.0
    for i in range(2):
        total = 0.0
        for j in range(DEGREE + 1):
            total += AT_CHECKS[i, j] * coefficients[j]
        worst = max(worst, abs(total - _evaluate_in_step(c, event, t, h, a + (b - a) * CHECKS[i])))
    # The ends are known exactly, whatever the matrix's rounding.
    coefficients[0], coefficients[DEGREE] = nodes[0], nodes[DEGREE]
    nearest = math.inf
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
        slope, _ = evaluate_event_slope(c, event, c.count[MODE], t, c.y)
        coefficients[0] = slope * h * (b - a)
    if worst <= max(RESOLVED, RESOLVED_ERRORS * c.rtol) * largest or worst < NO_ZERO * nearest:
        return Fit.RESOLVED
    return Fit.UNLIKE if worst > UNLIKE * largest else Fit.CLOSE


@internal
def _find_crossing(c, event, direction, t, h, a, b, before, on_surface):
    """Return the first crossing within [a, b] of the polynomial in ``c.bernstein`` (-1: none) and the sign after it."""
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
            if here != 0:
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
            if after != before and (direction == 0 or direction == after):
                return _locate(c, event, t, h, a + (b - a) * left, a + (b - a) * right, before), after
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


@internal
def _push(stack, place, left, right, depth):
    stack[4 * place], stack[4 * place + 1], stack[4 * place + 2] = left, right, depth


@internal
def _locate(c, event, t, h, left, right, before):
    """Return where an event function leaves the sign ``before`` in [left, right].

    It is found by the Illinois form of regula falsi, then by halving.
    """
    f_right = _evaluate_in_step(c, event, t, h, right)
    if f_right == 0.0:
        return right
    f_left = _evaluate_in_step(c, event, t, h, left)
    # Just after an event the function is zero to rounding at the left end: look for a time at which it has its sign.
    if f_left * before <= 0.0:
        width = right - left
        f_left = 0.0
        for k in range(1, NEAREST + 1):
            trial = left + width * 2.0**-k
            value = _evaluate_in_step(c, event, t, h, trial)
            if value * before > 0.0:
                left, f_left = trial, value
                break
        if f_left == 0.0:
            return left
    if f_right * before > 0.0:
        return right
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
