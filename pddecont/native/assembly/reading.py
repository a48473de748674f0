"""Values between base points, and where the past is read."""

from __future__ import annotations

from math import inf

from pddecont.native.arrays import Floats, Integers, entry
from pddecont.native.assembly.lagrange import evaluate_lagrange

# So few values are summed up one after the other, more of them together.
FEW = 4


@entry
def weigh_values(
    weights: Floats, columns: Integers, n: int, m: int, values: Floats, n_values: int, result: Floats
) -> None:
    """Write the sums of base ``values`` (n_base, n_values) in ``columns`` (n, m) times ``weights`` of the same shape.

    ``result`` has the shape (n, n_values).
    """
    if n_values <= FEW:
        for i in range(n):
            for q in range(n_values):
                total = 0.0
                for k in range(m):
                    total += weights[i * m + k] * values[columns[i * m + k] * n_values + q]
                result[i * n_values + q] = total
        return
    for i in range(n):
        for q in range(n_values):
            result[i * n_values + q] = 0.0
        for k in range(m):
            weight = weights[i * m + k]
            first = columns[i * m + k] * n_values
            for q in range(n_values):
                result[i * n_values + q] += weight * values[first + q]


@entry
def read_states(
    weights: Floats,
    columns: Integers,
    n: int,
    m: int,
    values: Floats,
    n_values: int,
    states: Integers,
    rows: Integers,
    n_read: int,
    n_rows: int,
    result: Floats,
) -> None:
    """Write what :func:`weigh_values` makes of ``states`` (n_read,) alone to ``rows`` (n_read,) of ``result``.

    Its shape is (n, n_rows); other rows stay.
    """
    for i in range(n):
        for r in range(n_read):
            total = 0.0
            for k in range(m):
                total += weights[i * m + k] * values[columns[i * m + k] * n_values + states[r]]
            result[i * n_rows + rows[r]] = total


@entry
def weigh_reads(
    starts: Floats,
    lengths: Floats,
    interval: Integers,
    place: Floats,
    n: int,
    lag: float,
    lags: Floats,
    period: float,
    wraps: Integers,
    read: Integers,
    base: Floats,
    barycentric: Floats,
    m: int,
    sigma: Floats,
    weights: Floats,
) -> float:
    """Write at which ``sigma`` (n,) of its interval each point reads, and the ``weights`` (n, m) there.

    Points lie at ``place`` of ``interval`` and read ``lag`` and ``lags`` (n,) before, ``wraps`` periods moved, in the
    intervals ``read``; mesh intervals have ``starts`` and ``lengths``. Returns the largest modulus of ``sigma``; -1
    where an interval has no length.
    """
    farthest = 0.0
    for i in range(n):
        time = starts[interval[i]] + place[i] * lengths[interval[i]] - lag + wraps[i] * period
        length = lengths[read[i]]
        if not abs(length) > 0.0:
            return -1.0
        sigma[i] = (time - starts[read[i]] - lags[i]) / length
        if not abs(sigma[i]) < inf:
            return inf
        farthest = max(farthest, abs(sigma[i]))
    evaluate_lagrange(sigma, n, base, barycentric, m, weights)
    return farthest


@entry
def move_reads(
    weights: Floats,
    columns: Integers,
    n: int,
    m: int,
    differentiate: Floats,
    values: Floats,
    n_values: int,
    times: Floats,
    starts: Floats,
    stretches: Floats,
    n_theta: int,
    which: Integers,
    n_which: int,
    read: Integers,
    sigma: Floats,
    lengths: Floats,
    slopes: Floats,
    out: Floats,
) -> None:
    """Write how what is read moves with the components ``which`` of theta, ``out`` (n, n_values, n_which).

    What is read are the base ``values`` (n_base, n_values) in ``columns`` (n, m) with ``weights`` of the same shape,
    at ``sigma`` (n,) of the intervals ``read``. ``times`` (n, n_theta) are the coefficients of the times that are read,
    ``starts`` and ``stretches`` (n_intervals, n_theta) those of the intervals' starts and lengths, ``lengths`` the
    lengths themselves. ``differentiate`` (m, m) takes base values to slopes; ``slopes`` has room for m numbers.
    """
    for i in range(n):
        for k in range(m):
            slopes[k] = 0.0
            for b in range(m):
                slopes[k] += weights[i * m + b] * differentiate[b * m + k]
        j = read[i]
        for q in range(n_values):
            slope = 0.0
            for k in range(m):
                slope += slopes[k] * values[columns[i * m + k] * n_values + q]
            slope /= lengths[j]
            for w in range(n_which):
                c = which[w]
                moved = times[i * n_theta + c] - starts[j * n_theta + c] - sigma[i] * stretches[j * n_theta + c]
                out[(i * n_values + q) * n_which + w] = slope * moved
