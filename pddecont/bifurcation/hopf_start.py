"""The branch of periodic orbits that is born at a Hopf point.

Near the point the orbits are x + 2 Re(z q e^(i omega t)), |z|^2 proportional to the parameter's distance. The first is
solved for with its amplitude along this profile given and the parameter free; from there the branch goes one way.

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), section 3.5; Engelborghs, Luzyanina, in 't Hout,
Roose, SIAM J. Sci. Comput. 22 (2001).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.branch_start import BranchStart
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, NewtonSettings, Solution, correct, solve_adaptively, tangent_at
from pddecont.equilibrium import Birth
from pddecont.orbit import OrbitEvaluation, PeriodicOrbitSystem, Sizes, make_resting_orbit

Array = NDArray[np.float64]
# The part of the range over which orbits are thought to grow, to tell how large they become.
SHARE = 0.25
# The first orbit, as a part of that size.
FIRST = 0.05
# A state that does not swing with the others counts by this part of them.
SMALLEST = 1e-3
# Orbits are not thought to become smaller than this part of the equilibrium's own size, nor larger than so many times.
LEAST, MOST = 1e-2, 10.0


def start_at_hopf(birth: Birth, settings: BranchSettings) -> BranchStart:
    """Return the start of the branch of orbits that is born at a Hopf point.

    Raises
    ------
    ConvergenceError
        If no small orbit is found there.
    """
    at = birth.equilibrium
    motion, q = at.motion, birth.vector / np.max(np.abs(birth.vector))
    own = float(np.max(np.abs(at.states), initial=0.0)) or 1.0
    grown = 2.0 * np.sqrt(abs(birth.growth) * SHARE * settings.widths[0]) * float(np.max(np.abs(birth.vector)))
    amplitude = float(np.clip(grown, LEAST * own, MOST * own)) if np.isfinite(grown) else own
    period = 2.0 * np.pi / birth.frequency
    rest = make_resting_orbit(
        motion.numeric, motion.mode, at.states, at.parameters, motion.method, period, settings.rule
    ).with_free(settings.free)
    times = rest.mesh.base_times(rest.theta)
    profile = (np.exp(1j * birth.frequency * times)[:, None] * q).real
    # The phase is fixed along the profile: an orbit at rest has none.
    problem = replace(rest.problem, reference=at.states + profile)
    sizes = np.maximum(amplitude * np.abs(q), SMALLEST * amplitude)
    system = PeriodicOrbitSystem(problem, Sizes(sizes, period, settings.widths), settings.rule)
    direction = np.zeros(len(rest.x))
    direction[problem.unknowns.values] = amplitude * profile.ravel()

    def solve(on_mesh: PeriodicOrbitSystem, guess: Array, carried: list[Array]) -> Solution[OrbitEvaluation]:
        along, resting = carried
        return correct(on_mesh, resting + FIRST * along, along, NewtonSettings(), guess)

    found, solution = solve_adaptively(system, rest.x + FIRST * direction, solve, (direction, rest.x))
    along = np.zeros(len(solution.x))
    along[found.problem.unknowns.values] = (solution.at.orbit.values - at.states).ravel()
    tangent = tangent_at(solution, found.scaling, along)
    return BranchStart(CurvePoint(found, solution.at, None, tangent), one_way=True)
