"""Zeros of event functions within a step, found on the continuous extension and located to rounding.

Along a step an event function is taken as the polynomial of degree 8 through nine of its values, halving the step until two more
values agree with it. In Bernstein form a polynomial has no more zeros in an interval than its coefficients change sign; halving (de
Casteljau) until each part has one change or none finds every crossing that the polynomial shows, a double one within a step too.

Reference: Farouki, The Bernstein polynomial basis: a centennial retrospective, Comput. Aided Geom. Design 29 (2012), sections 3 and 6.
"""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.kernel.calls import at, call, inner
from pddecont.simulate.kernel.past import near, read, read_slopes, state_at
from pddecont.simulate.kernel.slopes import slopes
from pddecont.simulate.kernel.tables import MODE, UNRESOLVED

DEGREE = 8
NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
CHECKS = np.array([0.3183, 0.8211])
RESOLVED, RESOLVED_ERRORS, UNSEEN = 1e-10, 10.0, 1e-3
FAR = 4.0
MAX_HALVINGS = 6
MAX_SPLITS = 40
ROW = 10


def _bernstein(x):
    basis = [math.comb(DEGREE, k) * x**k * (1.0 - x) ** (DEGREE - k) for k in range(DEGREE + 1)]
    return np.stack(basis, axis=-1)


TO_BERNSTEIN = np.ascontiguousarray(np.linalg.inv(_bernstein(NODES)))
AT_CHECKS = np.ascontiguousarray(_bernstein(CHECKS))


@inner
def event_value(c, event, t, y):
    """Return an event function's value."""
    if c.reads[event] == 1:
        read(c, t, y, c.xd, 0)
    c.gradient[0] = 0.0
    call(c.event, event, t, y, c.xd, c.p, c.gradient)
    return c.gradient[0]


@inner
def _along(c, event, t, h, s):
    y = at(c.trial, 2 * c.dimension)
    state_at(c, s, y, c.n_full if c.reads[event] == 1 else c.n)
    return event_value(c, event, t + s * h, y)


@inner
def slope_and_size(c, event, mode, t, y):
    """Return dh/dt along the flow of ``mode``, and how far from zero an event function may be and still be zero to rounding.

    The latter is what rounding in its terms, and in the time at which it is looked at, makes of it. The derivatives dh/dx, dh/dxd,
    dh/dt stay in ``c.gradient``.
    """
    n, m, gradient = c.n, c.n_pairs, c.gradient
    slopes(c, mode, t, y, c.slope)
    for i in range(n + m + 1):
        gradient[i] = 0.0
    read(c, t, y, c.xd, 0)
    call(c.event_jacobian, event, t, y, c.xd, c.p, gradient)
    slope, moving = gradient[n + m], abs(gradient[n + m])
    size = moving * abs(t)
    for i in range(n):
        slope += gradient[i] * c.slope[i]
        moving += abs(gradient[i] * c.slope[i])
        size += abs(gradient[i] * y[i])
    if c.reads[event] == 1:
        read_slopes(c, t, y, c.slope, c.xd_slope)
        for i in range(m):
            slope += gradient[n + i] * c.xd_slope[i]
            moving += abs(gradient[n + i] * c.xd_slope[i])
            size += abs(gradient[n + i] * c.xd[i])
    return slope, 1e-14 * size + 4.0 * near(t) * moving


@inner
def first_crossing(c, event, direction, t, h, side):
    """Return ``s`` in [0, 1] of the first crossing of an event function in a direction (0: any), or -1, and its sign at the end.

    ``side`` is the sign that it had when the step began; 0 says that it begins on its zero, which is then no crossing.
    """
    stack = c.stack
    top = 0
    stack[0], stack[1], stack[2] = 0.0, 1.0, 0.0
    before = side
    while top >= 0:
        a, b, depth = stack[4 * top], stack[4 * top + 1], stack[4 * top + 2]
        top -= 1
        on_surface = a == 0.0 and before == 0 and not _jumped(c, event, t, h)
        resolved = _interpolate(c, event, t, h, a, b, on_surface)
        if resolved == 2:
            after = 1 if c.bernstein[ROW] > 0.0 else -1
            if before * after < 0 and direction * after >= 0:
                return a, after
            before = after
            continue
        if resolved == -1 and depth >= MAX_HALVINGS:
            c.count[UNRESOLVED] = 1
        if resolved <= 0 and depth < MAX_HALVINGS:
            middle = 0.5 * (a + b)
            _push(stack, top + 1, middle, b, depth + 1.0)
            _push(stack, top + 2, a, middle, depth + 1.0)
            top += 2
            continue
        found, before = _walk(c, event, direction, t, h, a, b, before, on_surface)
        if found >= 0.0:
            return found, before
    return -1.0, before


@inner
def _jumped(c, event, t, h):
    """Whether an event function that was zero has left its zero in a jump: a delayed value jumps where the step begins."""
    near_start = abs(_along(c, event, t, h, 0.0))
    return near_start > 1e-9 * (near_start + abs(_along(c, event, t, h, 0.5)) + abs(_along(c, event, t, h, 1.0)))


@inner
def _interpolate(c, event, t, h, a, b, on_surface):
    """Write an event function's Bernstein coefficients on [a, b].

    Returns 1 if it is that polynomial, 0 if it is not quite, -1 if it is something else, 2 if it is far from zero.

    Where it begins on its zero the coefficients are those of the function divided by the distance from it, one fewer.
    """
    coefficients, nodes = c.bernstein, at(c.bernstein, ROW)
    low, high = math.inf, -math.inf
    for i in range(DEGREE + 1):
        nodes[i] = _along(c, event, t, h, a + (b - a) * NODES[i])
        low, high = min(low, nodes[i]), max(high, nodes[i])
    largest = max(abs(low), abs(high))
    # Between its nodes a polynomial leaves their range by no more than the Lebesgue constant allows, 2.1 for these nine.
    if not on_surface and abs(low + high) > FAR * (high - low):
        return 2
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
        worst = max(worst, abs(total - _along(c, event, t, h, a + (b - a) * CHECKS[i])))
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
        # The slope at the zero itself is known apart from the polynomial's rounding: a motion may leave tangentially, or hop by little.
        slope, _ = slope_and_size(c, event, c.count[MODE], t, c.y)
        coefficients[0] = slope * h * (b - a)
    if worst <= max(RESOLVED, RESOLVED_ERRORS * c.rtol) * largest or worst < 0.1 * nearest:
        return 1
    return -1 if worst > UNSEEN * largest else 0


@inner
def _walk(c, event, direction, t, h, a, b, before, on_surface):
    """Return the first crossing within [a, b] (-1: none) and the sign at its end."""
    degree = DEGREE - 1 if on_surface else DEGREE
    bounds, spare_left, spare_right = at(c.stack, 4 * 32), at(c.bernstein, 62 * ROW), at(c.bernstein, 63 * ROW)
    for i in range(degree + 1):
        c.bernstein[2 * ROW + i] = c.bernstein[i]
    top = 0
    _push(bounds, 0, 0.0, 1.0, 0.0)
    while top >= 0:
        row, below = at(c.bernstein, (2 + top) * ROW), at(c.bernstein, (3 + top) * ROW)
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
        elif changes == 1 or splits >= MAX_SPLITS or top > 26:
            after = 1 if last > 0.0 else -1 if last < 0.0 else before
            if after != before and (direction == 0 or direction == after):
                return _locate(c, event, t, h, a + (b - a) * left, a + (b - a) * right, before), after
            before = after
        else:
            # De Casteljau at the middle: the left part is looked at first, so it goes on top.
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


@inner
def _push(stack, place, left, right, depth):
    stack[4 * place], stack[4 * place + 1], stack[4 * place + 2] = left, right, depth


@inner
def _locate(c, event, t, h, left, right, before):
    """Return where an event function leaves the sign ``before`` in [left, right]: the Illinois form of regula falsi, then halving."""
    f_right = _along(c, event, t, h, right)
    if f_right == 0.0:
        return right
    f_left = _along(c, event, t, h, left)
    # Just after an event the function is zero at the left end to rounding: look for a moment at which it is on its side.
    if f_left * before <= 0.0:
        width = right - left
        f_left = 0.0
        for k in range(1, 61):
            trial = left + width * 2.0**-k
            value = _along(c, event, t, h, trial)
            if value * before > 0.0:
                left, f_left = trial, value
                break
        if f_left == 0.0:
            return left
    if f_right * before > 0.0:
        return right
    smallest = near(t) / abs(h) / 64.0
    kept = 0
    for k in range(200):
        if right - left <= smallest:
            break
        if k < 60:
            s = (left * f_right - right * f_left) / (f_right - f_left)
            if not left < s < right:
                s = 0.5 * (left + right)
        else:
            s = 0.5 * (left + right)
        if s <= left or s >= right:
            break
        value = _along(c, event, t, h, s)
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
