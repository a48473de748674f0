"""Where times lie on a mesh."""

from __future__ import annotations

from math import floor, isfinite

from pddecont.native.arrays import Floats, Integers, entry


@entry
def locate_times(
    times: Floats,
    chooser: Floats,
    n: int,
    edges: Floats,
    lengths: Floats,
    candidates: Integers,
    n_candidates: int,
    period: float,
    interval: Integers,
    sigma: Floats,
    wraps: Integers,
) -> None:
    """Write the mesh interval of each of ``n`` times, where it is in it, and how many periods later than there.

    Of the intervals numbered in ``candidates``, which begin at ``edges``, the last is taken that begins no later than
    the time's ``chooser``, moved by whole periods into the first; those are not counted where ``period`` is 0.
    """
    for i in range(n):
        turns = 0.0
        if period != 0.0 and isfinite(chooser[i] / period):
            turns = floor(chooser[i] / period)
        at = chooser[i] - turns * period
        low = 0
        high = n_candidates
        while low < high:
            middle = (low + high) // 2
            if edges[candidates[middle]] <= at:
                low = middle + 1
            else:
                high = middle
        place = candidates[max(low - 1, 0)]
        interval[i] = place
        wraps[i] = int(turns)
        sigma[i] = 0.0
        if lengths[place] != 0.0:
            sigma[i] = (times[i] - turns * period - edges[place]) / lengths[place]
