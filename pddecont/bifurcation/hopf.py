"""Hopf (HB) and Hopf-Hopf (HH): where orbits shrink to an equilibrium, whose own equations say where.

A branch comes near with orbits (``orbit.amplitude``); the last of them is the guess. Its mean is nearly the
equilibrium, its largest harmonic the eigenvector, and on a curve of torus bifurcations its pair of multipliers
exp(+-i omega_2 T) tells the second frequency up to multiples of 2 pi / T, among which the characteristic matrix
chooses. The point is recorded as an orbit that does not move, with the period 2 pi / omega.

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), sections 3.4 and 8.6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.extended_system import ExtendedEvaluation
from pddecont.bifurcation.fold import remove_fold_multiplier
from pddecont.bifurcation.kinds import SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.torus import TorusFunction, remove_pair
from pddecont.collocation import MeshRule
from pddecont.continuation import BranchPoint, BranchState, CurvePoint, Termination
from pddecont.equilibrium import CharacteristicMatrix, ConstantMotion, HopfPoint, HopfProblem, solve_hopf
from pddecont.errors import ConvergenceError
from pddecont.orbit import Orbit, OrbitEvaluation, SegmentSpan, make_eventless, measure_size, resegment
from pddecont.reasons import make_reason
from pddecont.stability import Multipliers

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
HOPF_LABEL, HOPF_HOPF_LABEL = "HB", "HH"
# Codes of how a branch that shrinks ends: at the point, at one beyond the range, at none that was found.
HOPF, BEYOND_RANGE, NOT_LOCATED = "hopf_point", "hopf_beyond_range", "hopf_not_located"
# Harmonics of the orbit among which the one that lives on at the Hopf point is chosen.
HARMONICS = np.arange(1, 9)
# Frequencies of the second pair are looked for up to this many times the first.
HIGHEST = 40
# How many times its last amplitude and step an orbit may lie away from where it shrinks to, in scaled unknowns.
FAR = 20.0


def end_at_equilibrium(
    termination: Termination,
    last: BranchState[Any],
    settings: BranchSettings,
    emit: Callable[[BranchPoint[Any]], object],
    sign: int,
) -> Termination:
    """Emit the Hopf point to which a branch shrinks after its ``last`` point; return how the branch ended.

    ``sign`` is that of this direction's arclengths.
    """
    at = last.point.at
    inner: OrbitEvaluation = at.inner if isinstance(at, ExtendedEvaluation) else at
    orbit = inner.orbit
    label = HOPF_LABEL if len(orbit.free) == 1 else HOPF_HOPF_LABEL
    try:
        guess = _guess_point(at)
        found = solve_hopf(_pose_problem(inner), guess)
        _check_near(inner, guess, found, last.step)
    except ConvergenceError as exc:
        return replace(termination, detail=make_reason(NOT_LOCATED, why=str(exc)))
    free = found.parameters[list(orbit.problem.free_index)]
    where = dict(zip(orbit.problem.free, free.tolist(), strict=True))
    if any(not low <= value <= high for value, (low, high) in zip(free, settings.ranges, strict=True)):
        return replace(termination, detail=make_reason(BEYOND_RANGE, label=label, **_name_places(where)))
    if settings.wants(label):
        system, rest = settings.make_system(make_constant_orbit(orbit, found, settings.rule))
        point = CurvePoint(system, system.at(rest.x), None, np.zeros(len(rest.x)))
        away = measure_size(orbit, inner.system.sizes.states)
        state = replace(last, point=point, arclength=last.arclength + sign * away)
        emit(BranchPoint(state, label, 0, error=found.error))
    return replace(termination, detail=make_reason(HOPF, label=label, **_name_places(where)))


def make_constant_orbit(orbit: Orbit, point: HopfPoint, rule: MeshRule) -> Orbit:
    """Return the orbit that stays at a Hopf point, with as many turns of the first pair in a period as ``orbit``."""
    turns = max(1, round(float(point.frequencies[0]) * orbit.period / (2.0 * np.pi)))
    mode = orbit.signature.segments[0].mode
    whole = resegment(
        orbit.with_free(()), [SegmentSpan(make_eventless(orbit.numeric.model, mode), 0.0, orbit.period)], rule, 1
    )
    problem = replace(whole.problem, parameters=point.parameters)
    values = np.tile(point.states, (whole.mesh.n_base, 1))
    period = 2.0 * np.pi * turns / point.frequencies[0]
    return Orbit(problem, problem.unknowns.join(values, np.array([period]), 0.0, np.zeros(0)))


def _name_places(where: dict[str, float]) -> dict[str, float]:
    return {f"at {name}": value for name, value in where.items()}


def _pose_problem(at: OrbitEvaluation) -> HopfProblem:
    orbit, sizes = at.orbit, at.system.sizes
    return HopfProblem(_find_motion(orbit), orbit.problem.free_index, sizes.states, np.array(sizes.ranges))


def _find_motion(orbit: Orbit) -> ConstantMotion:
    return ConstantMotion(orbit.numeric, orbit.signature.segments[0].mode, orbit.problem.delay)


def _guess_point(at: OrbitEvaluation | ExtendedEvaluation) -> HopfPoint:
    """Return what a small orbit says of the point that it shrinks to."""
    orbit = at.orbit
    mean, omega, vector = _read_harmonic(orbit)
    if len(orbit.free) == 1:
        return HopfPoint(mean, np.array([omega]), vector[None], orbit.parameters)
    defining = at.system.defining if isinstance(at, ExtendedEvaluation) else None
    if not isinstance(defining, TorusFunction):
        raise ConvergenceError(
            "where this curve ends the equilibrium has one pair of roots on the imaginary axis, and which of these "
            "points it is only terms of higher order tell (a curve of folds ends where the first Lyapunov coefficient "
            "is zero)"
        )
    pair, _ = defining.find_pair(at.inner if isinstance(at, ExtendedEvaluation) else at)
    second, other = _choose_frequency(_find_motion(orbit).linearise(mean, orbit.parameters), pair, orbit.period)
    return HopfPoint(mean, np.array([omega, second]), np.stack([vector, other]), orbit.parameters)


def _read_harmonic(orbit: Orbit) -> tuple[Array, float, Complex]:
    """Return an orbit's mean (n_states,), and the frequency and coefficient (n_states,) of its largest harmonic."""
    mesh, theta = orbit.mesh, orbit.theta
    points = mesh.grid(mesh.basis.nodes)
    weights = np.outer(mesh.length @ theta, mesh.basis.weights).ravel() / orbit.period
    states, times = mesh.interpolate(orbit.values, points), mesh.times(points) @ theta
    mean = weights @ states
    frequencies = 2.0 * np.pi * HARMONICS / orbit.period
    harmonics = (weights * np.exp(-1j * np.outer(frequencies, times))) @ (states - mean)
    largest = int(np.argmax(np.linalg.norm(harmonics, axis=1)))
    return mean, float(frequencies[largest]), harmonics[largest]


def _choose_frequency(matrix: CharacteristicMatrix, pair: complex, period: float) -> tuple[float, Complex]:
    """Return the frequency omega with exp(i omega T) in a pair of multipliers that is nearest a root, and its vector.

    At this angle there is no multiple of the first pair's frequency, whose multipliers are 1.
    """
    angle = abs(float(np.angle(pair)))
    turns = 2.0 * np.pi * np.arange(HIGHEST + 1)
    candidates = np.concatenate([turns + angle, turns[1:] - angle]) / period
    found = [matrix.find_smallest(1j * omega) for omega in candidates]
    best = min(range(len(found)), key=lambda i: found[i][0] / (1.0 + candidates[i]))
    return float(candidates[best]), found[best][1]


def _check_near(at: OrbitEvaluation, guess: HopfPoint, found: HopfPoint, step: float) -> None:
    """Raise ConvergenceError if the point found is not where the orbit shrinks to, or is none."""
    sizes, free = at.system.sizes, list(at.orbit.problem.free_index)
    moved = np.concatenate(
        [
            (found.states - guess.states) / sizes.states,
            found.frequencies / guess.frequencies - 1.0,
            (found.parameters - guess.parameters)[free] / np.array(sizes.ranges),
        ]
    )
    reach = FAR * (measure_size(at.orbit, sizes.states) + step)
    if not np.max(np.abs(moved)) <= reach:
        raise ConvergenceError("the Hopf point that was found is not the one that the orbits shrink to")


def _remove_both(m: Multipliers) -> Complex:
    """Return the multipliers without those of both pairs."""
    return remove_pair(replace(m, nontrivial=remove_fold_multiplier(m)))


HOPF_BIFURCATION = SpecialPointKind(HOPF_LABEL, "Hopf", on_branches=True, remove_critical=remove_fold_multiplier)
HOPF_HOPF = SpecialPointKind(HOPF_HOPF_LABEL, "Hopf-Hopf", on_curves=True, remove_critical=_remove_both)
