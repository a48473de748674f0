"""The cycle in a trajectory that has nearly a known period, whether it has settled or not."""

from __future__ import annotations

import numpy as np

from pddecont.errors import SignatureError
from pddecont.simulate.period_detection import Cycle
from pddecont.simulate.trajectory import Trajectory

# By how much of it a period may be missed.
NEAR = 0.2


def find_nearby_cycle(trajectory: Trajectory, period: float, n_periods: int) -> Cycle:
    """Return the last stretch of a trajectory from an event to the same one about ``period`` later.

    Where no event happens in the last period it is that period itself. ``n_periods`` is the cycle's number of forcing
    periods.

    Raises
    ------
    SignatureError
        If no event comes again in time.
    """
    events, end = trajectory.events, trajectory.t_end
    if not len(events) or events.t[-1] < end - period:
        times = np.array([end - period, end])
        return Cycle((), times, (int(trajectory.arc[-1]),), n_periods, trajectory.mode[-1], trajectory)
    for last in range(len(events) - 1, -1, -1):
        if events.t[last] < end - period:
            break
        missed = np.abs(events.t[last] - events.t[:last] - period)
        same = [i for i in range(last) if events.segment[i] == events.segment[last] and missed[i] < NEAR * period]
        if same:
            first = min(same, key=lambda i: missed[i])
            arcs = tuple(int(arc) for arc in events.arc[first:last])
            return Cycle(
                events.segment[first + 1 : last + 1],
                events.t[first : last + 1],
                arcs,
                n_periods,
                trajectory.find_mode(arcs[0]),
                trajectory,
            )
    raise SignatureError("it does not come back after about the period of the orbit")
