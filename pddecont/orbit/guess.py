"""From a cycle, the last of a trajectory or one in a table, to a first guess of an orbit."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshRule
from pddecont.delay import DelayMethod
from pddecont.errors import ConvergenceError
from pddecont.model import check_signature
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.remesh import breaking_times_vary, make_mesh, settle_reads
from pddecont.orbit.signature import Signature, link_delayed_events, make_eventless
from pddecont.orbit.varying_links import link_varying_jumps

Array = NDArray[np.float64]
# Meshes at most until the breaking times that are found on a cycle stand still, and how still, in periods: Newton's
# method moves them from there, and must not move them past one another.
N_MESHES, STILL = 8, 1e-8


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
    orbit = _sample(bare, make_mesh(bare, theta, rule), cycle, theta)
    if breaking_times_vary(bare):
        orbit = _settle_breaking_times(orbit, bare, cycle, rule)
    return link_varying_jumps(orbit)


def _sample(bare: OrbitProblem, mesh: Mesh, cycle: Cycle, theta: Array) -> Orbit:
    """Return a cycle on a mesh that was made for it."""
    n = len(bare.segments)
    breaking = mesh.reference_breaking
    times = cycle.times[0] + mesh.base_times(np.concatenate([theta, breaking]))
    values = np.empty((mesh.n_base, bare.numeric.n_states))
    for s in range(n):
        inside = slice(mesh.first_base[s], mesh.last_base[s] + 1)
        values[inside] = cycle.evaluate(s, times[inside])
    problem = replace(bare, mesh=mesh, reference=values if bare.signature.needs_phase_reference else None)
    return Orbit(problem, problem.unknowns.join(values, theta[:n], bare.phase, np.zeros(0), breaking))


def _settle_breaking_times(orbit: Orbit, bare: OrbitProblem, cycle: Cycle, rule: MeshRule) -> Orbit:
    """Return a cycle on a mesh with the breaking times behind delays that vary, where the cycle itself has them.

    On polynomials that know nothing of them they are found roughly, on those of the next mesh nearly. Where a cycle is
    so rough that delays cannot be read, that is left to whoever solves for the orbit.
    """
    n_known = len(orbit.theta)
    try:
        for _ in range(N_MESHES):
            mesh, before = make_mesh(bare, orbit.theta, rule, orbit=orbit), orbit.mesh
            orbit = _sample(bare, mesh, cycle, orbit.theta[:n_known])
            if _stand_still(before, mesh, STILL * orbit.period):
                break
        return settle_reads(orbit)
    except ConvergenceError:
        return orbit


def _stand_still(before: Mesh, after: Mesh, near: float) -> bool:
    """Return whether two meshes have the same breaking times, to within ``near``."""
    alike = [(b.delay, b.source.tolist()) for b in before.breaking] == [
        (b.delay, b.source.tolist()) for b in after.breaking
    ]
    return alike and bool(np.all(np.abs(before.reference_breaking - after.reference_breaking) <= near))
