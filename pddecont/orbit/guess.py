"""From the last cycle of a trajectory to an orbit's unknowns on a mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.operator import DelayMethod
from pddecont.errors import SignatureError
from pddecont.model.codegen import NumericModel
from pddecont.model.system import Segment, check_signature
from pddecont.orbit.mesh import Mesh
from pddecont.orbit.meshing import MeshRule, new_mesh
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.simulate.recognise import Cycle

Array = NDArray[np.float64]


def orbit_from_cycle(numeric: NumericModel, p: Array, delay: DelayMethod, cycle: Cycle, rule: MeshRule) -> tuple[OrbitProblem, Array]:
    """Return the boundary-value problem of a cycle's signature and the cycle as first guess of its unknowns."""
    model = numeric.model
    check_signature(model, cycle.signature)
    segments = tuple(model.segments[name] for name in cycle.signature) or (eventless(cycle.mode),)
    durations = np.diff(cycle.times)
    theta = np.concatenate([durations, numeric.delays.value(p)])
    start = cycle.times[0] % float(numeric.period.value(p)[0]) if model.forced else 0.0
    timers = timers_of(numeric, segments, p, durations)
    bare = OrbitProblem(numeric, segments, Mesh(rule.degree, len(segments), ()), delay, p, (), cycle.n_periods, None, start, timers)
    mesh = new_mesh(bare, theta, rule)
    times = cycle.times[0] + mesh.base_times(theta)
    values = np.empty((mesh.n_base, numeric.n_states))
    for s in range(len(segments)):
        inside = slice(mesh.first_base[s], mesh.last_base[s] + 1)
        values[inside] = cycle.states(s, times[inside])
    reference = values if not cycle.signature and not model.forced else None
    problem = replace(bare, mesh=mesh, reference=reference)
    return problem, problem.layout.join(values, durations, start, np.zeros(0))


def timers_of(numeric: NumericModel, segments: tuple[Segment, ...], p: Array, durations: Array) -> tuple[tuple[int, int, int], ...]:
    """Return (s, s_a, w) for each segment s that ends by a delayed event: started by the end of segment s_a, w periods before.

    The end of s lies at the end of s_a plus the event's delay minus w periods.
    """
    ends, period = np.cumsum(durations), float(np.sum(durations))
    timers = []
    for s, segment in enumerate(segments):
        event = numeric.model.events.get(segment.event)
        if event is None or event.after is None:
            continue
        delay = float(numeric.event_delay(event.name).value(p)[0])
        sources = [a for a, other in enumerate(segments) if other.event == event.after]
        if not sources:
            raise SignatureError(f"segment '{segment.name}' ends at '{event.name}', which comes after '{event.after}', but no segment of "
                                 f"this orbit ends at '{event.after}'")  # fmt: skip
        turns = [(ends[a] + delay - ends[s]) / period for a in sources]
        best = min(range(len(sources)), key=lambda i: abs(turns[i] - round(turns[i])))
        timers.append((s, sources[best], round(turns[best])))
    return tuple(timers)
