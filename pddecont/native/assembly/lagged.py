"""How reads of the past move with the durations of the present and of earlier periods."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Integers, entry


@entry
def move_lagged_reads(
    slopes: Floats,
    times: Floats,
    n: int,
    n_lags: int,
    n_moving: int,
    n_segments: int,
    interval: Integers,
    sigma: Floats,
    wraps: Integers,
    starts: Floats,
    lengths: Floats,
    widths: Floats,
    result: Floats,
) -> None:
    """Write ``slopes`` (n,) times how the fractions move at which reads lie in their intervals.

    Point i moves by ``times`` (n, n_lags, n_moving) and reads, a fixed delay before, the ``interval`` of as many
    periods ago as ``wraps`` says, at its fraction ``sigma``; all of shape (n,). ``starts`` and ``lengths``, of shape
    (n_intervals, n_lags, n_moving), say how intervals move, ``widths`` (n_intervals,) are their own lengths. ``result``
    has the shape of ``times``.
    """
    size = n_lags * n_moving
    for i in range(n):
        read = interval[i]
        for w in range(n_lags):
            for j in range(n_moving):
                at = w * n_moving + j
                move = times[i * size + at]
                # Whole periods lie between a point and what it reads of an earlier one.
                if j < n_segments and w >= 1 and w <= wraps[i]:
                    move += 1.0
                if w >= wraps[i]:
                    of = read * size + at - wraps[i] * n_moving
                    move -= starts[of] + sigma[i] * lengths[of]
                result[i * size + at] = slopes[i] * (move / widths[read])


@entry
def stretch_lagged_rates(
    rates: Floats,
    n: int,
    n_lags: int,
    n_moving: int,
    interval: Integers,
    wraps: Integers,
    lengths: Floats,
    result: Floats,
) -> None:
    """Take off ``result`` (n, n_lags, n_moving) the ``rates`` (n,) times how the lengths of the intervals read move."""
    size = n_lags * n_moving
    for i in range(n):
        for at in range(wraps[i] * n_moving, size):
            result[i * size + at] -= rates[i] * lengths[interval[i] * size + at - wraps[i] * n_moving]
