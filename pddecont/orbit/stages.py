"""An orbit of a delay equation as a guess of the same orbit with the chain's stages as states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.direct import Direct
from pddecont.model.codegen import NumericModel
from pddecont.orbit.mesh import Places
from pddecont.orbit.meshing import MeshRule, new_mesh, transfer
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]


def with_stages(problem: OrbitProblem, x: Array, numeric: NumericModel, order: int, n: int, rule: MeshRule) -> tuple[OrbitProblem, Array]:
    """Return the problem of ``numeric`` (as ``model.chain_states`` makes it) and the orbit ``x`` as its guess.

    Stage i begins as the orbit i tau / n ago, its variables w_k as delta^k times derivatives of the polynomials.
    """
    model, (values, durations, start, _) = problem.numeric.model, problem.layout.split(x)
    theta, n_segments = problem.theta(x), problem.mesh.n_segments
    bare = replace(problem, numeric=numeric, delay=Direct(), parameters=problem.all_parameters(x), free=(), reference=None)
    mesh = new_mesh(bare, durations, rule)
    columns = [transfer(problem.mesh, theta, values, mesh, durations)]
    times, period = mesh.base_times(durations), float(np.sum(durations))
    edges, lengths = problem.mesh.start @ theta, problem.mesh.length @ theta
    derivatives = [values]
    for _ in range(1, order):
        local = np.matmul(problem.mesh.basis.differentiate, derivatives[-1][problem.mesh.base_index]) / lengths[:, None, None]
        derivatives.append(np.empty_like(values))
        derivatives[-1][problem.mesh.base_index] = local
    for state, delay in model.delayed:
        delta = theta[n_segments + delay] / n
        for stage in range(1, n + 1):
            at = (times - stage * delta) % period
            interval = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, len(edges) - 1)
            places = Places(interval, np.clip((at - edges[interval]) / lengths[interval], 0.0, 1.0))
            columns += [delta**k * problem.mesh.at(d[:, [state]], places) for k, d in enumerate(derivatives)]
    guess = np.concatenate(columns, axis=1)
    reference = None if problem.reference is None else guess
    made = replace(bare, mesh=mesh, reference=reference)
    return made, made.layout.join(guess, durations, start, np.zeros(0))
