"""Following a branch: predict, correct, watch the test functions, adapt the step, stop with a reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric, Problem, correct, correct_at, tangent
from pddecont.continuation.locate import locate
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]


class End(Enum):
    """Why a branch ends, with advice."""

    RANGE = "reached the end of the range; widen 'range' to go on"
    MAX_POINTS = "reached 'max_points'; raise it, or 'step: {max}', to go on"
    STEP_TOO_SMALL = ("the step fell below 'step: {min}'; look at the last orbits for a grazing, a vanishing segment or a sharp "
                      "fold, refine 'mesh', or lower 'step: {min}'")  # fmt: skip
    SPECIAL = "stopped at a special point where the signature of the orbit changes"
    CLOSED = "came back to its start"


@dataclass(frozen=True)
class Termination:
    """How one direction of a branch ended."""

    end: End
    detail: str = ""

    def __str__(self) -> str:
        return f"{self.end.value}{f' ({self.detail})' if self.detail else ''}"


class Followed(Problem, Protocol):
    """A problem that a branch can be followed in."""

    def metric(self) -> Metric:
        """Return the sizes and weights that lengths are measured with."""
        ...

    def renew(self, x: Array, tangent: Array) -> tuple[Followed, Array, Array]:
        """Return the problem for the next step, with ``x`` and ``tangent`` in its unknowns (a new mesh, say)."""
        ...


@dataclass(frozen=True)
class TestFunction:
    """A function along the branch whose zero is a special point of ``kind``; ``stops`` if the branch ends there."""

    __test__ = False
    kind: str
    value: Callable[[Followed, Array], float]
    stops: bool = False


@dataclass(frozen=True)
class StepSettings:
    """Arclength steps in scaled unknowns, and what they are adapted to.

    A free parameter's range counts as length one, and so does one typical size of the orbit.
    """

    initial: float = 0.02
    min: float = 1e-6
    max: float = 0.1
    max_points: int = 500
    max_turn: float = 0.3
    newton: NewtonSettings = field(default_factory=lambda: NewtonSettings(max_iterations=8))


@dataclass(frozen=True, eq=False)
class State:
    """Where a branch stands: all that is needed to go on from here, or to resume."""

    problem: Followed
    x: Array
    tangent: Array
    arclength: float
    step: float
    n_points: int


@dataclass(frozen=True, eq=False)
class Point:
    """One point of a branch; ``kind`` is empty for an ordinary one. ``arclength`` is signed by the direction."""

    state: State
    kind: str
    n_iterations: int


def follow(state: State, bounds: Sequence[tuple[int, float, float]], tests: Sequence[TestFunction], settings: StepSettings,
           emit: Callable[[Point], None], sign: int) -> Termination:  # fmt: skip
    """Follow a branch from ``state`` along its tangent, handing each point to ``emit``; return how it ended.

    Parameters
    ----------
    state
        A point on the branch and the direction to go.
    bounds
        For each bounded unknown its place and its lower and upper bound.
    tests
        Test functions; a change of sign is located and emitted as a special point.
    sign
        Sign given to the arclengths of this direction.
    """
    tested, before = None, []
    while state.n_points < settings.max_points:
        problem, x, direction = state.problem.renew(state.x, state.tangent)
        state = replace(state, problem=problem, x=x, tangent=direction)
        if tested is not problem:
            tested, before = problem, [test.value(problem, x) for test in tests]
        metric = problem.metric()
        try:
            solution, step = _advance(state, metric, settings)
        except ConvergenceError as exc:
            return Termination(End.STEP_TOO_SMALL, str(exc))
        crossed = _first_crossing(state.x, solution.x, bounds)
        if crossed is not None:
            index, value, fraction = crossed
            guess = state.x + fraction * (solution.x - state.x)
            try:
                solution = correct_at(state.problem, guess, index, value, metric, settings.newton)
            except ConvergenceError:
                # A fold next to the bound: come closer with smaller steps.
                state = replace(state, step=step / 2)
                if state.step < settings.min:
                    return Termination(End.STEP_TOO_SMALL)
                continue
        after = [test.value(state.problem, solution.x) for test in tests]
        special = _specials(state, solution, tests, before, after, settings)
        length = np.sqrt(metric.dot(solution.x - state.x, solution.x - state.x))
        for test, point, fraction in special:
            at = replace(state, x=point.x, arclength=state.arclength + sign * fraction * length)
            emit(Point(at, test.kind, point.n_iterations))
            if test.stops:
                return Termination(End.SPECIAL, test.kind)
        direction = tangent(state.problem, solution.x, metric, state.tangent)
        reached = replace(state, x=solution.x, tangent=direction, arclength=state.arclength + sign * length,
                          step=_next_step(step, solution.n_iterations, metric.dot(direction, state.tangent), settings),
                          n_points=state.n_points + 1)  # fmt: skip
        emit(Point(reached, "" if crossed is None else "EP", solution.n_iterations))
        if crossed is not None:
            return Termination(End.RANGE)
        state, before = reached, after
    return Termination(End.MAX_POINTS)


def _advance(state: State, metric: Metric, settings: StepSettings) -> tuple[Solution, float]:
    """Return the next point and the step that reached it; halve the step until the corrector converges."""
    step = state.step
    while True:
        try:
            predicted = state.x + step * state.tangent
            solution = correct(state.problem, predicted, state.tangent, metric, settings.newton)
            moved = solution.x - predicted
            if np.sqrt(metric.dot(moved, moved)) > settings.max_turn * step:
                raise ConvergenceError("the branch turns too sharply for this step", solution.history)
            return solution, step
        except ConvergenceError:
            if step <= settings.min:
                raise
            step = max(0.5 * step, settings.min)


def _next_step(step: float, n_iterations: int, cosine: float, settings: StepSettings) -> float:
    factor = 1.5 if n_iterations <= 3 else 1.0 if n_iterations <= 5 else 0.5
    if cosine < 0.95:
        factor = min(factor, 0.7)
    return float(np.clip(factor * step, settings.min, settings.max))


def _first_crossing(x0: Array, x1: Array, bounds: Sequence[tuple[int, float, float]]) -> tuple[int, float, float] | None:
    """Return (unknown, bound, fraction of the step) of the first bound passed between two points."""
    hits = []
    for index, low, high in bounds:
        for bound, passed in ((low, x1[index] < low), (high, x1[index] > high)):
            if passed:
                hits.append(((bound - x0[index]) / (x1[index] - x0[index]), index, bound))
    if not hits:
        return None
    fraction, index, bound = min(hits)
    return index, bound, fraction


def _specials(state: State, end: Solution, tests: Sequence[TestFunction], before: Sequence[float], after: Sequence[float],
              settings: StepSettings) -> list[tuple[TestFunction, Solution, float]]:  # fmt: skip
    """Return the special points between ``state`` and ``end`` with their fraction of the step, in order."""
    found = []
    for test, f0, f1 in zip(tests, before, after, strict=True):
        if f0 * f1 < 0.0 or (f1 == 0.0 and f0 != 0.0):
            point = locate(state.problem, test.value, state.x, end.x, f0, f1, state.problem.metric(), settings.newton)
            if point is not None:
                found.append((test, *point))
    return sorted(found, key=lambda item: item[2])
