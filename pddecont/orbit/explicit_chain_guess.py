"""An orbit of a delay equation as a guess of the same orbit with the chain's stages as states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshRule, transfer
from pddecont.delay import Direct
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.remesh import make_mesh
from pddecont.orbit.signature import Signature

Array = NDArray[np.float64]


def guess_chain_states(orbit: Orbit, numeric: NumericModel, order: int, n: int, rule: MeshRule) -> Orbit:
    """Return an orbit as a guess of that of ``numeric``, the model with chains of ``n`` stages as states.

    Stage i begins as the orbit i tau / n ago, its variables w_k as delta^k times derivatives of the polynomials.
    """
    old, theta, durations = orbit.mesh, orbit.theta, orbit.durations
    bare = OrbitProblem(
        Signature(numeric, orbit.signature.segments),
        Mesh(rule.degree, old.n_segments, ()),
        Direct(),
        orbit.parameters,
        (),
        orbit.problem.n_periods,
        None,
        orbit.problem.phase,
        orbit.problem.links,
    )
    mesh = make_mesh(bare, durations, rule)
    columns = [transfer(old, theta, orbit.values, mesh, durations)]
    times, lengths = mesh.base_times(durations), old.length @ theta
    derivatives = [orbit.values]
    for _ in range(1, order):
        local = np.matmul(old.basis.differentiate, derivatives[-1][old.base_index]) / lengths[:, None, None]
        derivatives.append(np.empty_like(orbit.values))
        derivatives[-1][old.base_index] = local
    for read in orbit.numeric.model.delayed:
        delta = theta[old.n_segments + read.delay] / n
        for stage in range(1, n + 1):
            points, _ = old.locate(theta, times - stage * delta)
            columns += [
                delta**k * old.interpolate(d[:, [read.state]], points.clipped()) for k, d in enumerate(derivatives)
            ]
    guess = np.concatenate(columns, axis=1)
    made = replace(bare, mesh=mesh, reference=guess if bare.signature.needs_phase_reference else None)
    return Orbit(made, made.unknowns.join(guess, durations, orbit.start, np.zeros(0)))
