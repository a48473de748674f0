"""Values of one mesh at the base points of another."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Integers, entry
from pddecont.native.assembly.lagrange import evaluate_lagrange


def find_times(
    starts: Floats,
    lengths: Floats,
    segment: Integers,
    n: int,
    base: Floats,
    m: int,
    durations: Floats,
    others: Floats,
    times: Floats,
    owner: Integers,
) -> int:
    """Write the times of the base points of ``n`` intervals, as far into segments that last ``others``; count them.

    ``owner`` says which segment each belongs to.
    """
    n_points = 0
    here = 0.0
    there = 0.0
    for j in range(n):
        s = segment[j]
        if j > 0 and s != segment[j - 1]:
            here += durations[s - 1]
            there += others[s - 1]
        # Neighbours share the point between them; segments do not.
        n_points = (m - 1) * j + s
        for k in range(m):
            time = starts[j] + base[k] * lengths[j]
            times[n_points + k] = there + (time - here) * (others[s] / durations[s])
            owner[n_points + k] = s
    return n_points + m


def find_interval(starts: Floats, lengths: Floats, first: int, last: int, at: float) -> int:
    """Return the last interval from ``first`` to ``last`` that begins no later than ``at``.

    One without length holds nothing, unless there is no other.
    """
    low = first
    high = last + 1
    while low < high:
        middle = (low + high) // 2
        if starts[middle] <= at:
            low = middle + 1
        else:
            high = middle
    place = max(low - 1, first)
    while place > first and not lengths[place] > 0.0:
        place -= 1
    while place < last and not lengths[place] > 0.0:
        place += 1
    return place if lengths[place] > 0.0 else first


@entry
def transfer_values(
    starts: Floats,
    lengths: Floats,
    segment: Integers,
    n: int,
    base: Floats,
    m: int,
    durations: Floats,
    old_starts: Floats,
    old_lengths: Floats,
    old_last: Integers,
    old_base: Floats,
    old_barycentric: Floats,
    old_m: int,
    old_durations: Floats,
    values: Floats,
    n_values: int,
    times: Floats,
    owner: Integers,
    sigma: Floats,
    weights: Floats,
    result: Floats,
) -> None:
    """Write base ``values`` of an old mesh at the base points of a new one, ``result`` (n_base, n_values).

    Of each mesh its intervals' ``starts`` and ``lengths`` are given, its base points (m,) and the ``durations`` of its
    segments; of the new one the ``segment`` of its ``n`` intervals, of the old one the last interval of each. A base
    point reads at the same fraction of its segment: at ``times`` (n_base,), which are those of the old mesh. ``owner``
    and ``sigma`` (n_base,) and ``weights`` (n_base, old_m) are worked in.
    """
    n_points = find_times(starts, lengths, segment, n, base, m, durations, old_durations, times, owner)
    for i in range(n_points):
        s = owner[i]
        place = find_interval(old_starts, old_lengths, old_last[s - 1] + 1 if s > 0 else 0, old_last[s], times[i])
        sigma[i] = 0.0
        if old_lengths[place] != 0.0:
            sigma[i] = (times[i] - old_starts[place]) / old_lengths[place]
        if sigma[i] < 0.0:
            sigma[i] = 0.0
        elif sigma[i] > 1.0:
            sigma[i] = 1.0
        # From here on it is the first base point of the interval that is read.
        owner[i] = (old_m - 1) * place + s
    evaluate_lagrange(sigma, n_points, old_base, old_barycentric, old_m, weights)
    for i in range(n_points):
        for q in range(n_values):
            total = 0.0
            for k in range(old_m):
                total += weights[i * old_m + k] * values[(owner[i] + k) * n_values + q]
            result[i * n_values + q] = total
