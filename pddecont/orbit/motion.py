"""The motion that goes on from an orbit's own past, and what it does there as the guess of another orbit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshRule
from pddecont.delay import Direct
from pddecont.errors import SignatureError
from pddecont.orbit.clocks import list_started_events
from pddecont.orbit.guess import guess_from_cycle
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.past import make_past
from pddecont.orbit.reach import find_reach
from pddecont.orbit.signature import is_rotation
from pddecont.simulate import Simulator, Trajectory, find_nearby_cycle, record_trajectory, restart_motion

Array = NDArray[np.float64]
# Where in its longest segment a motion starts: no part that a symmetry makes special.
PLACE = 0.4789
# How much longer than any delay the past is kept.
ROOM = 1.01


def simulate_onwards(orbit: Orbit, p: Array, n_turns: float) -> Trajectory:
    """Return the motion at parameters ``p`` that has an orbit as its past, for ``n_turns`` of the orbit's period.

    It starts in the orbit's longest segment. Delayed values are read from the past, whatever the orbit's own method.

    Raises
    ------
    ConvergenceError
        If it comes to a halt.
    """
    s = int(np.argmax(orbit.durations))
    begin = float(orbit.event_times[s] + PLACE * orbit.durations[s])
    at = orbit.mesh.locate(orbit.theta, np.array([begin]), segment=s)[0]
    states = orbit.mesh.interpolate(orbit.values, at)[0]
    simulator = Simulator(orbit.numeric, Direct())
    values = simulator.values(np.asarray(p, dtype=float))
    past = make_past(orbit, begin - ROOM * max(values.longest, find_reach(orbit)), begin)
    pending = [(orbit.start + t, name) for t, since, name in list_started_events(orbit) if since < begin < t]
    t = orbit.start + begin
    state = restart_motion(simulator, values, past, t, states, orbit.signature.segments[s].mode, pending)
    return record_trajectory(simulator, values.p, state, t + n_turns * orbit.period)


def guess_from_motion(orbit: Orbit, turns: float, rule: MeshRule) -> Orbit:
    """Return what the motion that goes on from an orbit does, as the guess of an orbit with another signature.

    It is followed for as long as delays reach and ``turns`` of the orbit's period more.

    Raises
    ------
    ConvergenceError
        If it comes to a halt.
    SignatureError
        If it does not come back, or keeps the orbit's signature.
    """
    numeric, p, period, n = orbit.numeric, orbit.parameters, orbit.period, orbit.problem.n_periods
    delays = [find_reach(orbit)]
    events = numeric.model.events.values()
    delays += [float(numeric.event_delay(event.name).value(p)[0]) for event in events if event.delay is not None]
    trajectory = simulate_onwards(orbit, p, turns + float(np.ceil(max(delays) / period)))
    if numeric.model.forced:
        period = n * float(numeric.period.value(p)[0])
    cycle = find_nearby_cycle(trajectory, period, n)
    if is_rotation(cycle.signature, orbit.signature.names if orbit.signature.has_events else ()):
        raise SignatureError("it leaves for another orbit of the same signature")
    return guess_from_cycle(numeric, p, orbit.problem.delay, cycle, rule)
