"""Values between base points."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Integers, entry


@entry
def weigh_values(
    weights: Floats, columns: Integers, n: int, m: int, values: Floats, n_values: int, result: Floats
) -> None:
    """Write the sums of base ``values`` (n_base, n_values) in ``columns`` (n, m) times ``weights`` of the same shape.

    ``result`` has the shape (n, n_values).
    """
    for i in range(n):
        for q in range(n_values):
            result[i * n_values + q] = 0.0
        for k in range(m):
            weight = weights[i * m + k]
            first = columns[i * m + k] * n_values
            for q in range(n_values):
                result[i * n_values + q] += weight * values[first + q]
