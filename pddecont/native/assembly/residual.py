"""How far a periodic orbit's base values are from its equations, at all points where these hold."""

from __future__ import annotations

from typing import NamedTuple

from pddecont.native.arrays import Floats, Integers, entry
from pddecont.native.calls import call, offset


class Equations(NamedTuple):
    """Which functions of the model hold where; the arrays have to outlive it.

    Points are the collocation points interval by interval, then the segments' ends. ``address`` and ``which`` tell the
    vector field at each collocation point, then the reset, then the event function at each segment's end; of a segment
    without an event function its address is 0.
    """

    # Shapes: base_index (n_intervals, degree + 1), slopes (degree, degree + 1), next_base (n_segments,).
    degree: int
    n_intervals: int
    n_segments: int
    n_states: int
    n_reads: int
    base_index: Integers
    slopes: Floats
    next_base: Integers
    address: Integers
    which: Integers


def set_zero(numbers: Floats, n: int) -> None:
    """Set numbers to zero: a model's functions leave out those that always are."""
    for i in range(n):
        numbers[i] = 0.0


@entry
def fill_residual(
    c: Equations, values: Floats, h: Floats, t: Floats, x: Floats, xd: Floats, p: Floats, work: Floats, result: Floats
) -> None:
    """Write z' - h f at the collocation points, z - g at the segments' starts, and the event functions at their ends.

    ``values`` (n_base, n_states), ``h`` (n_intervals,); ``t`` (n_points,), ``x`` (n_points, n_states) and ``xd``
    (n_points, n_reads) at the points. ``work`` has room for what a function writes; ends without an event function are
    left alone.
    """
    n = c.n_states
    for j in range(c.n_intervals):
        for i in range(c.degree):
            k = j * c.degree + i
            set_zero(work, n)
            call(c.address[k], c.which[k], t[k], offset(x, k * n), offset(xd, k * c.n_reads), p, work)
            for q in range(n):
                slope = 0.0
                for b in range(c.degree + 1):
                    slope += c.slopes[i * (c.degree + 1) + b] * values[c.base_index[j * (c.degree + 1) + b] * n + q]
                result[k * n + q] = slope - h[j] * work[q]
    ends = c.n_intervals * c.degree
    for s in range(c.n_segments):
        k = ends + s
        set_zero(work, n)
        call(c.address[k], c.which[k], t[k], offset(x, k * n), offset(xd, k * c.n_reads), p, work)
        for q in range(n):
            result[k * n + q] = values[c.next_base[s] * n + q] - work[q]
    for s in range(c.n_segments):
        k = ends + s
        event = k + c.n_segments
        if c.address[event] != 0:
            set_zero(work, 1)
            call(c.address[event], c.which[event], t[k], offset(x, k * n), offset(xd, k * c.n_reads), p, work)
            result[(ends + c.n_segments) * n + s] = work[0]
