"""The method, degree and mesh that meet an error on an orbit at the least cost (``--accuracy``).

Candidates are solved and compared with a much finer solution, so the error that counts is the orbit's own and not the
equation's defect. The cost of a candidate is counted, not timed: the same input chooses the same everywhere. The
cheapest is then solved for exactly as its step will do it, on meshes that may be others: what that orbit's own estimate
and the finer solution say must be within the accuracy too, or the mesh is tightened.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pddecont.collocation import MeshRule, transfer
from pddecont.delay import Chebyshev, Direct
from pddecont.errors import ConvergenceError, ResultsError
from pddecont.orbit import Orbit, adapt_mesh, estimate_error, measure_states, solve_orbit
from pddecont.runfile import Delay, Holding, Mesh, PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.execution.orbit import make_guess
from pddecont.steps.registry import list_step_kinds

DEGREES = (4, 6, 8, 10, 12)
# How much finer the solution is that candidates are measured against, and by how much a mesh that misses is tightened.
FINER, TIGHTER = 1e-2, 0.1
MAX_TIGHTER = 5
# Meshes that are tried for the step's own orbit to meet the accuracy, and the part of it that the next one aims at.
MAX_CONFIRMED, AIM = 4, 0.8
LEAST = 1e-12
# Methods in the order in which they are tried.
METHODS = (
    (Delay.model_validate({"method": "direct"}), Direct()),
    (Delay.model_validate({"method": "chebyshev", "n": 32}), Chebyshev(32)),
)


@dataclass(frozen=True)
class Choice:
    """What meets the accuracy asked for: a delay method, a mesh, and what they leave on the orbit."""

    delay: Delay
    mesh: Mesh
    error: float
    n_unknowns: int
    n_intervals: int

    @property
    def cost(self) -> int:
        """Unknowns times the length of a row's block: what filling and factoring the Jacobian costs."""
        return self.n_unknowns * (self.mesh.degree + 1)

    @property
    def text(self) -> str:
        """The choice in words."""
        method = {"direct": "the delay equation itself"}.get(
            self.delay.method, f"Chebyshev delay line of {self.delay.n} points"
        )
        return (
            f"{method}, degree {self.mesh.degree}, mesh tolerance {self.mesh.tol:.1e}: {self.n_intervals} intervals, "
            f"{self.n_unknowns} unknowns, estimated error {self.error:.1e}"
        )


def choose_settings(context: Context, step: PlannedStep[Any], recorded_choice: str | None) -> PlannedStep[Any]:
    """Return the step with the delay and mesh chosen for the run's accuracy, where it leaves them open.

    ``recorded_choice`` is that of an earlier run of the step. A branch has the choice of the orbit it starts from.
    """
    accuracy = context.plan.accuracy
    if accuracy is None or not step.chooses:
        return step
    is_branch = list_step_kinds()[step.kind].holds == Holding.BRANCH
    if recorded_choice is None and is_branch and step.source is not None:
        recorded_choice = context.read_source(step.source)[1].meta.get("choice")
    if recorded_choice is not None:
        return step.with_choice(*_read_choice(step.name, recorded_choice))
    if is_branch:
        return step.with_choice(METHODS[0][0], Mesh.model_validate({"tol": max(TIGHTER * accuracy, LEAST)}))
    choice = find_cheapest_choice(context, step, accuracy)
    context.reporter.note(f"{step.name}: for an accuracy of {accuracy:g}: {choice.text}")
    return step.with_choice(choice.delay, choice.mesh)


def _read_choice(name: str, text: str) -> tuple[Delay, Mesh]:
    try:
        chosen = json.loads(text)
        return Delay.model_validate(chosen["delay"]), Mesh.model_validate(chosen["mesh"])
    except (ValueError, KeyError, TypeError) as exc:
        raise ResultsError(
            f"the method and mesh recorded for step '{name}' cannot be read; the file is damaged"
        ) from exc


def find_cheapest_choice(context: Context, step: PlannedStep[Any], accuracy: float) -> Choice:
    """Return the cheapest method and mesh whose orbit has no larger error than ``accuracy``.

    Raises
    ------
    ConvergenceError
        If no orbit is found near the step's guess, or no mesh reaches the accuracy.
    """
    guess = make_guess(context, replace(step, rule=MeshRule(6, None, accuracy)))
    failure: ConvergenceError | None = None
    for delay, method in METHODS:
        try:
            candidates, fine = _find_candidates(Orbit(replace(guess.problem, delay=method), guess.x), delay, accuracy)
        except ConvergenceError as exc:
            failure = failure or exc
            continue
        best: Choice | None = None
        for candidate in candidates:
            if best is not None and candidate.cost >= best.cost:
                break
            choice = _confirm(context, step, candidate, fine, accuracy)
            if choice is not None and (best is None or choice.cost < best.cost):
                best = choice
        if best is not None:
            return best
    if failure is not None:
        raise ConvergenceError(
            f"step '{step.name}': no periodic orbit near the guess at an accuracy of {accuracy:g}: {failure}. What "
            "usually helps: a longer transient (raise 't_end'), 'delay' and 'mesh' of your own",
            failure.history,
        )
    raise ConvergenceError(
        f"step '{step.name}': no mesh reaches an error of {accuracy:g}; rounding leaves more. Raise 'accuracy'"
    )


def _find_candidates(guess: Orbit, delay: Delay, accuracy: float) -> tuple[list[Choice], Orbit]:
    """Return choices that seem to meet the accuracy, the cheapest first, and the finer orbit they are measured by."""
    first = _solve(guess, MeshRule(6, None, accuracy))
    fine = _solve(first, MeshRule(DEGREES[-1], None, max(FINER * accuracy, LEAST)))
    found = []
    for degree in DEGREES:
        tol = min(accuracy / TIGHTER, 0.1)
        for _ in range(MAX_TIGHTER):
            try:
                other = _solve(first, MeshRule(degree, None, tol))
            except ConvergenceError:
                break
            error = measure_distance(other, fine)
            if error <= accuracy:
                found.append(_make_choice(other, delay, tol, error))
                break
            tol *= TIGHTER
    return sorted(found, key=lambda choice: choice.cost), fine


def _confirm(
    context: Context, step: PlannedStep[Any], candidate: Choice, fine: Orbit, accuracy: float
) -> Choice | None:
    """Return the choice, its mesh tightened where need be, with which the step itself meets the accuracy, or None."""
    tol = candidate.mesh.tol
    assert tol is not None, "a choice has a mesh tolerance"
    for _ in range(MAX_CONFIRMED):
        chosen = step.with_choice(candidate.delay, _make_mesh(candidate.mesh.degree, tol))
        try:
            orbit = solve_orbit(make_guess(context, chosen), chosen.rule).at.orbit
        except ConvergenceError:
            return None
        error = estimate_error(orbit)
        if not orbit.signature.needs_phase_reference:
            # Two orbits whose phase is free are not the same at the same times.
            error = max(error, measure_distance(orbit, fine))
        if error <= accuracy:
            return _make_choice(orbit, candidate.delay, tol, error)
        if tol <= LEAST:
            return None
        tol = max(AIM * tol * accuracy / error, LEAST)
    return None


def _make_choice(orbit: Orbit, delay: Delay, tol: float, error: float) -> Choice:
    return Choice(delay, _make_mesh(orbit.mesh.degree, tol), error, len(orbit.x), orbit.mesh.n_intervals)


def _make_mesh(degree: int, tol: float) -> Mesh:
    return Mesh.model_validate({"degree": degree, "tol": tol})


def _solve(guess: Orbit, rule: MeshRule) -> Orbit:
    return solve_orbit(adapt_mesh(guess, rule), rule).at.orbit


def measure_distance(orbit: Orbit, fine: Orbit) -> float:
    """Return how far an orbit is from a finer one.

    States count relative to their sizes, durations and start to the period.
    """
    there = transfer(fine.mesh, fine.theta, fine.values, orbit.mesh, orbit.theta)
    states = np.max(np.abs(orbit.values - there) / measure_states(fine.values))
    times = max(float(np.max(np.abs(orbit.durations - fine.durations))), abs(orbit.start - fine.start)) / fine.period
    return float(max(states, times))
