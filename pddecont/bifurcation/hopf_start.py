"""The branch of periodic orbits that is born at a Hopf point.

Near the point the orbits are x + 2 Re(z q e^(i omega t)), |z|^2 proportional to the parameter's distance. The first is
solved for with its amplitude along this profile given and the parameter free; from there the branch goes one way.

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), section 3.5; Engelborghs, Luzyanina, in 't Hout,
Roose, SIAM J. Sci. Comput. 22 (2001).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.branch_start import BranchStart
from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation, ExtendedSystem, extend_system
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, NewtonSettings, Solution, correct, solve_adaptively, tangent_at
from pddecont.equilibrium import Birth, measure_sizes
from pddecont.errors import ConvergenceError
from pddecont.orbit import Orbit, OrbitEvaluation, PeriodicOrbitSystem, Sizes, make_resting_orbit

Array = NDArray[np.float64]
# The part of the range over which orbits are thought to grow, to tell how large they become.
SHARE = 0.25
# The first orbit, as a part of that size.
FIRST = 0.05
# The same on curves of special orbits, as parts of the equilibrium's own size: the first with which one is found.
ON_CURVES = (0.2, 0.1, 0.05, 0.3, 0.02)
# A state that does not swing with the others counts by this part of them.
SMALLEST = 1e-3
# Orbits are not thought to become smaller than this part of the equilibrium's own size, nor larger than so many times.
LEAST, MOST = 1e-2, 10.0


@dataclass(frozen=True, eq=False)
class _SmallOrbits:
    """Orbits next to a Hopf point: their equations, and in their unknowns the equilibrium and one that is larger.

    Both are orbits, which another mesh takes over; the way that orbits grow is the difference.
    """

    system: PeriodicOrbitSystem
    rest: Array
    largest: Array


def start_at_hopf(birth: Birth, settings: BranchSettings) -> BranchStart:
    """Return the start of the branch of orbits that is born at a Hopf point.

    Raises
    ------
    ConvergenceError
        If no small orbit is found there.
    """
    own = float(np.max(measure_sizes(birth.equilibrium.states)))
    grown = 2.0 * np.sqrt(abs(birth.growth) * SHARE * settings.widths[0]) * float(np.max(np.abs(birth.vector)))
    small = _make_small(birth, settings, float(np.clip(grown, LEAST * own, MOST * own)) if np.isfinite(grown) else own)

    def solve(on_mesh: PeriodicOrbitSystem, guess: Array, carried: list[Array]) -> Solution[OrbitEvaluation]:
        rest, largest = carried
        along = largest - rest
        return correct(on_mesh, rest + FIRST * along, along, NewtonSettings(), guess)

    guess = small.rest + FIRST * (small.largest - small.rest)
    found, solution = solve_adaptively(small.system, guess, solve, (small.rest, small.largest))
    tangent = tangent_at(solution, found.scaling, _find_growth(solution.at.orbit, birth))
    return BranchStart(CurvePoint(found, solution.at, None, tangent), one_way=True)


def start_curve_at_hopf(
    birth: Birth, settings: BranchSettings, label: str, define: Callable[[OrbitEvaluation], DefiningFunction]
) -> BranchStart:
    """Return the start of the curve of special orbits of the kind ``label`` that is born at a point of codimension two.

    ``define`` returns what is special of an orbit. The orbits of the curve lie at parameters that differ from the
    point's by the square of their amplitude.

    Raises
    ------
    ConvergenceError
        If no small orbit is found there.
    """
    own = float(np.max(measure_sizes(birth.equilibrium.states)))
    failure: ConvergenceError | None = None
    for part in ON_CURVES:
        small = _make_small(birth, settings, part * own)
        system = extend_system(small.system, define(small.system.at(small.largest)))

        def solve(on_mesh: ExtendedSystem, x: Array, carried: list[Array]) -> Solution[ExtendedEvaluation]:
            rest, largest = carried
            return correct(on_mesh, largest, largest - rest, NewtonSettings(), x)

        try:
            found, solution = solve_adaptively(system, small.largest, solve, (small.rest, small.largest))
        except ConvergenceError as exc:
            failure = exc
            continue
        tangent = tangent_at(solution, found.scaling, _find_growth(solution.at.orbit, birth))
        return BranchStart(CurvePoint(found, solution.at, None, tangent), label, one_way=True)
    assert failure is not None
    raise failure


def _make_small(birth: Birth, settings: BranchSettings, amplitude: float) -> _SmallOrbits:
    """Return the orbits next to a Hopf point up to one of an ``amplitude``, to the first order."""
    at = birth.equilibrium
    motion, q = at.motion, birth.vector / np.max(np.abs(birth.vector))
    period = 2.0 * np.pi / birth.frequency
    rest = make_resting_orbit(
        motion.numeric, motion.mode, at.states, at.parameters, motion.method, period, settings.rule
    ).with_free(settings.free)
    times = rest.mesh.base_times(rest.theta)
    profile = (np.exp(1j * birth.frequency * times)[:, None] * q).real
    # The phase is fixed along the profile: an orbit at rest has none.
    problem = replace(rest.problem, reference=at.states + profile)
    sizes = np.maximum(amplitude * np.abs(q), SMALLEST * amplitude)
    largest = rest.x.copy()
    largest[problem.unknowns.values] += amplitude * profile.ravel()
    system = PeriodicOrbitSystem(problem, Sizes(sizes, period, settings.widths), settings.rule)
    return _SmallOrbits(system, rest.x, largest)


def _find_growth(orbit: Orbit, birth: Birth) -> Array:
    """Return the direction in which an orbit grows."""
    along = np.zeros(len(orbit.x))
    along[orbit.problem.unknowns.values] = (orbit.values - birth.equilibrium.states).ravel()
    return along
