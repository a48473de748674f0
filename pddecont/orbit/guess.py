"""From a cycle, the last of a trajectory or one in a table, to a first guess of an orbit."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshRule
from pddecont.delay import DelayMethod
from pddecont.model import check_signature
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.remesh import make_mesh
from pddecont.orbit.signature import Signature, link_delayed_events, make_eventless
from pddecont.orbit.varying_links import link_varying_jumps

Array = NDArray[np.float64]


class Cycle(Protocol):
    """One period of a motion, wherever it comes from."""

    @property
    def signature(self) -> tuple[str, ...]:
        """The names of its segments; empty for a motion without events."""
        ...

    @property
    def times(self) -> Array:
        """Where they begin and end (n_segments + 1,)."""
        ...

    @property
    def n_periods(self) -> int:
        """Periods of the forcing in it; 1 for an autonomous model."""
        ...

    @property
    def mode(self) -> str:
        """The mode at its start."""
        ...

    def evaluate(self, segment: int, t: Array) -> Array:
        """Return the states at times ``t`` in a segment, shape (n_times, n_states)."""
        ...


def guess_from_cycle(numeric: NumericModel, p: Array, delay: DelayMethod, cycle: Cycle, rule: MeshRule) -> Orbit:
    """Return a cycle as a first guess of an orbit with its signature.

    Raises
    ------
    SignatureError
        If the cycle's segments do not follow one another.
    """
    model = numeric.model
    check_signature(model, cycle.signature)
    segments = tuple(model.segments[name] for name in cycle.signature) or (make_eventless(model, cycle.mode),)
    signature = Signature(numeric, segments)
    durations = np.diff(cycle.times)
    theta = np.concatenate([durations, numeric.delays.value(p)])
    start = cycle.times[0] % float(numeric.period.value(p)[0]) if model.forced else 0.0
    links = link_delayed_events(signature, p, durations)
    bare = OrbitProblem(
        signature, Mesh(rule.degree, len(segments), ()), delay, p, (), cycle.n_periods, None, start, links
    )
    mesh = make_mesh(bare, theta, rule)
    times = cycle.times[0] + mesh.base_times(theta)
    values = np.empty((mesh.n_base, numeric.n_states))
    for s in range(len(segments)):
        inside = slice(mesh.first_base[s], mesh.last_base[s] + 1)
        values[inside] = cycle.evaluate(s, times[inside])
    problem = replace(bare, mesh=mesh, reference=values if signature.needs_phase_reference else None)
    return link_varying_jumps(Orbit(problem, problem.unknowns.join(values, durations, start, np.zeros(0))))
