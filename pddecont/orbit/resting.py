"""An equilibrium as a periodic orbit that does not move, of any period: what measures orbits measures it too."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshRule
from pddecont.delay import DelayMethod
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.remesh import make_mesh
from pddecont.orbit.signature import Signature, make_eventless

Array = NDArray[np.float64]
# The mesh of an orbit that nothing is asked of but its values.
COARSE = MeshRule(2, 1, None)


def make_resting_orbit(
    numeric: NumericModel,
    mode: str,
    states: Array,
    p: Array,
    delay: DelayMethod,
    period: float,
    rule: MeshRule = COARSE,
) -> Orbit:
    """Return the orbit that stays at ``states`` (n_states,) in a mode for a ``period``."""
    signature = Signature(numeric, (make_eventless(numeric.model, mode),))
    bare = OrbitProblem(signature, Mesh(rule.degree, 1, ()), delay, p)
    durations = np.array([period])
    mesh = make_mesh(bare, np.concatenate([durations, numeric.delays.value(p)]), rule)
    values = np.tile(states, (mesh.n_base, 1))
    problem = OrbitProblem(signature, mesh, delay, p, reference=values if signature.needs_phase_reference else None)
    return Orbit(problem, problem.unknowns.join(values, durations, 0.0, np.zeros(0)))
