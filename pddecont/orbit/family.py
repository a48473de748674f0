"""Whether an orbit is one of a family at fixed parameters: its equations leave something free."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from pddecont.continuation import equilibrate
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.system import PeriodicOrbitSystem, measure_orbit

# The equations leave a direction free where the smallest singular value of the Jacobian is below this part of the one
# before it.
FREE = 1e-6
# States that move along the family are those that move by this part of what moves most, in parts of their sizes.
MOVES = 0.1
# Larger systems take too long for a message.
LARGEST = 3000


def find_free_states(orbit: Orbit) -> tuple[str, ...]:
    """Return the states that move along a family which ``orbit`` belongs to; empty if it is isolated.

    Along a family of orbits at one set of parameters the Jacobian of the square equations is singular, and its null
    vector says what moves.
    """
    if orbit.problem.unknowns.size > LARGEST:
        return ()
    system = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit))
    matrix = equilibrate(system.at(orbit.x).jacobian(), system.scaling.scale).matrix
    _, sizes, directions = scipy.linalg.svd(matrix.toarray() if sp.issparse(matrix) else matrix)
    if sizes[-1] > FREE * sizes[-2]:
        return ()
    unknowns = orbit.problem.unknowns
    moves = np.max(np.abs(directions[-1][unknowns.values]).reshape(unknowns.mesh.n_base, unknowns.n_states), axis=0)
    names = orbit.signature.numeric.model.states
    return tuple(name for name, move in zip(names, moves, strict=True) if move > MOVES * np.max(moves))
