"""Where a piece of a mesh is cut into intervals."""

from __future__ import annotations

from pddecont.native.arrays import Floats, entry


@entry
def cut_piece(
    edges: Floats,
    heights: Floats,
    n: int,
    start: float,
    end: float,
    most: int,
    grid: Floats,
    totals: Floats,
    cuts: Floats,
) -> int:
    """Write the cuts of a piece from ``start`` to ``end``, fractions of it; return how many intervals it gets.

    Their number is the integral of a density with ``heights`` (n,) between ``edges`` (n + 1,), rounded up, ``most`` at
    most, and each has an equal share of it; ``grid`` and ``totals`` (n + 3,) are worked in.
    """
    n_grid = 1
    grid[0] = start
    for i in range(n + 1):
        if start < edges[i] < end:
            grid[n_grid] = edges[i]
            n_grid += 1
    grid[n_grid] = end
    totals[0] = 0.0
    k = 0
    for i in range(n_grid):
        middle = 0.5 * (grid[i + 1] + grid[i])
        while k + 1 < n and edges[k + 1] < middle:
            k += 1
        totals[i + 1] = totals[i] + heights[k] * (grid[i + 1] - grid[i])
    whole = totals[n_grid]
    cuts[0] = 0.0
    n_cuts = 1
    while n_cuts < most and n_cuts < whole:
        n_cuts += 1
    step = whole / n_cuts
    k = 0
    for i in range(1, n_cuts):
        share = step * i
        while k + 1 < n_grid and totals[k + 1] <= share:
            k += 1
        slope = (grid[k + 1] - grid[k]) / (totals[k + 1] - totals[k])
        cuts[i] = (slope * (share - totals[k]) + grid[k] - start) / (end - start)
    cuts[n_cuts] = 1.0
    return n_cuts
