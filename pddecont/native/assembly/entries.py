"""Entries of Jacobians: the slopes of a function at its points, times what its arguments are made of."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Integers, entry


@entry
def spread_slopes(slopes: Floats, n_slopes: int, factor: Floats, weights: Floats, n: int, m: int, out: Floats) -> None:
    """Write ``slopes`` (n_slopes, n) times ``factor`` (n,) times ``weights`` (n, m) to ``out`` (n_slopes, n, m)."""
    for k in range(n_slopes):
        for i in range(n):
            slope = slopes[k * n + i] * factor[i]
            for j in range(m):
                out[(k * n + i) * m + j] = slope * weights[i * m + j]


@entry
def spread_over_reads(
    slopes: Floats,
    which: Integers,
    n_slopes: int,
    factor: Floats,
    points: Integers,
    n: int,
    weights: Floats,
    n_points: int,
    m: int,
    out: Floats,
) -> None:
    """Write ``slopes`` (n_slopes, n) times ``factor`` (n,) times the weights of what they read, (n_slopes, n, m).

    Slope k is in a value that is read by ``weights[which[k]]`` of all, (n_kinds, n_points, m), at the ``points`` (n,).
    """
    for k in range(n_slopes):
        for i in range(n):
            slope = slopes[k * n + i] * factor[i]
            first = (which[k] * n_points + points[i]) * m
            for j in range(m):
                out[(k * n + i) * m + j] = slope * weights[first + j]


@entry
def add_moves(
    rates: Floats,
    out: Integers,
    which: Integers,
    n_rates: int,
    points: Integers,
    n: int,
    tables: Floats,
    n_points: int,
    n_moving: int,
    result: Floats,
) -> None:
    """Add ``rates`` (n_rates, n) times how what they are rates in moves to ``result`` (n_out, n, n_moving).

    Rate k is that of output ``out[k]`` in what moves by ``tables[which[k]]`` of all, (n_tables, n_points, n_moving), at
    the ``points`` (n,).
    """
    for k in range(n_rates):
        for i in range(n):
            rate = rates[k * n + i]
            first = (which[k] * n_points + points[i]) * n_moving
            to = (out[k] * n + i) * n_moving
            for j in range(n_moving):
                result[to + j] += rate * tables[first + j]


@entry
def stretch_moves(
    values: Floats,
    n_out: int,
    factor: Floats,
    interval: Integers,
    n: int,
    lengths: Floats,
    n_moving: int,
    result: Floats,
) -> None:
    """Multiply ``result`` (n_out, n, n_moving) by ``factor`` (n,) and take off what lengths of intervals do.

    That is ``values`` (n_out, n) times ``lengths`` (n_intervals, n_moving) of each point's ``interval`` (n,).
    """
    for k in range(n_out):
        for i in range(n):
            to = (k * n + i) * n_moving
            first = interval[i] * n_moving
            for j in range(n_moving):
                result[to + j] = result[to + j] * factor[i] - values[k * n + i] * lengths[first + j]
