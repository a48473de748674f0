"""The method, degree and mesh that meet an error on an orbit at the least cost (``--accuracy``).

Candidates are solved and compared with a much finer solution, so the error that counts is the orbit's own and not the equation's
defect. The cost of a candidate is counted, not timed: the same input chooses the same everywhere.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.chebyshev import Chebyshev
from pddecont.delay.direct import Direct
from pddecont.delay.operator import DelayMethod
from pddecont.errors import ConvergenceError, ResultsError
from pddecont.orbit.curve import settle
from pddecont.orbit.error import state_sizes
from pddecont.orbit.meshing import MeshRule, remeshed, transfer
from pddecont.orbit.problem import OrbitProblem
from pddecont.steps.context import Context
from pddecont.steps.orbit import first_guess
from pddecont.steps.schema import Delay, Mesh, Step

Array = NDArray[np.float64]
DEGREES = (4, 6, 8, 10, 12)
# How much finer the solution is that candidates are measured against, and by how much a mesh that misses is tightened.
FINER, TIGHTER = 1e-2, 0.1
MAX_TIGHTER = 5
LEAST = 1e-12


@dataclass(frozen=True)
class Choice:
    """What meets the accuracy asked for: a delay method, a mesh, and what they leave on the orbit."""

    delay: Delay
    mesh: Mesh
    error: float
    n_unknowns: int
    n_intervals: int

    @property
    def text(self) -> str:
        """The choice in words."""
        method = {"direct": "the delay equation itself"}.get(self.delay.method, f"Chebyshev delay line of {self.delay.n} points")
        return (f"{method}, degree {self.mesh.degree}, mesh tolerance {self.mesh.tol:.1e}: {self.n_intervals} intervals, "
                f"{self.n_unknowns} unknowns, estimated error {self.error:.1e}")  # fmt: skip


def resolved(context: Context, step: Step, recorded_choice: str | None) -> Step:
    """Return the step with the delay and mesh chosen for the run's accuracy, where it leaves them open.

    ``recorded_choice`` is that of an earlier run of the step. A branch has the choice of the orbit it starts from.
    """
    accuracy = context.plan.run.accuracy
    if accuracy is None or step.kind not in ("orbit", "continue") or step.mesh is not None or step.delay is not None:
        return step
    if recorded_choice is None and step.kind == "continue":
        assert step.source is not None
        recorded_choice = context.source(step.source)[1].meta.get("choice")
    if recorded_choice is not None:
        try:
            chosen = json.loads(recorded_choice)
            delay, mesh = Delay.model_validate(chosen["delay"]), Mesh.model_validate(chosen["mesh"])
        except (ValueError, KeyError, TypeError) as exc:
            raise ResultsError(f"the method and mesh recorded for step '{step.name}' cannot be read; the file is damaged") from exc
    elif step.kind == "continue":
        delay, mesh = Delay.model_validate({"method": "direct"}), Mesh.model_validate({"tol": max(TIGHTER * accuracy, LEAST)})
    else:
        choice = choose(context, step, accuracy)
        context.reporter.note(f"{step.name}: for an accuracy of {accuracy:g}: {choice.text}")
        delay, mesh = choice.delay, choice.mesh
    return step.model_copy(update={"delay": delay, "mesh": mesh})


def choose(context: Context, step: Step, accuracy: float) -> Choice:
    """Return the cheapest method and mesh whose orbit has no larger error than ``accuracy``.

    Raises
    ------
    ConvergenceError
        If no orbit is found near the step's guess, or no mesh reaches the accuracy.
    """
    trial = step.model_copy(update={"mesh": Mesh.model_validate({"degree": 6, "tol": accuracy}), "delay": None})
    problem, guess = first_guess(context, trial)
    failure: ConvergenceError | None = None
    for spec, method in (({"method": "direct"}, Direct()), ({"method": "chebyshev", "n": 32}, Chebyshev(32))):
        try:
            choice = _cheapest(problem, guess, Delay.model_validate(spec), method, accuracy)
        except ConvergenceError as exc:
            failure = failure or exc
            continue
        if choice is not None:
            return choice
    if failure is not None:
        raise ConvergenceError(f"step '{step.name}': no periodic orbit near the guess at an accuracy of {accuracy:g}: {failure}. What "
                               "usually helps: a longer transient (raise 't_end'), 'delay' and 'mesh' of your own",
                               failure.history)  # fmt: skip
    raise ConvergenceError(f"step '{step.name}': no mesh reaches an error of {accuracy:g}; rounding leaves more. Raise 'accuracy'")


def _cheapest(problem: OrbitProblem, guess: Array, delay: Delay, method: DelayMethod, accuracy: float) -> Choice | None:
    base = replace(problem, delay=method)
    first, solution = settle(*remeshed(base, guess, MeshRule(6, None, accuracy)), MeshRule(6, None, accuracy))
    fine_rule = MeshRule(DEGREES[-1], None, max(FINER * accuracy, LEAST))
    fine, exact = settle(*remeshed(first, solution.x, fine_rule), fine_rule)
    found = []
    for degree in DEGREES:
        tol = min(accuracy / TIGHTER, 0.1)
        for _ in range(MAX_TIGHTER):
            rule = MeshRule(degree, None, tol)
            try:
                other, own = settle(*remeshed(first, solution.x, rule), rule)
            except ConvergenceError:
                break
            error = distance(other, own.x, fine, exact.x)
            if error <= accuracy:
                mesh = Mesh.model_validate({"degree": degree, "tol": tol})
                found.append(Choice(delay, mesh, error, len(own.x), other.mesh.n_intervals))
                break
            tol *= TIGHTER
    # Unknowns times the length of a row's block: what filling and factoring the Jacobian costs.
    return min(found, key=lambda c: c.n_unknowns * (c.mesh.degree + 1), default=None)


def distance(problem: OrbitProblem, x: Array, fine: OrbitProblem, exact: Array) -> float:
    """Return how far an orbit is from a finer one: states relative to their sizes, durations and start to the period."""
    values, durations, start, _ = problem.layout.split(x)
    fine_values, fine_durations, fine_start, _ = fine.layout.split(exact)
    period = float(np.sum(fine_durations))
    there = transfer(fine.mesh, fine.theta(exact), fine_values, problem.mesh, problem.theta(x))
    states = np.max(np.abs(values - there) / state_sizes(fine_values))
    times = max(float(np.max(np.abs(durations - fine_durations))), abs(start - fine_start)) / period
    return float(max(states, times))
