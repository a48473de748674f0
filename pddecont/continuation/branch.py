"""Following a branch: predict, correct, watch the test functions, adapt the step, stop with a reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric, Problem, correct, correct_at, tangent_of
from pddecont.continuation.locate import MAX_MESHES, Located, locate
from pddecont.continuation.newton import NewtonSettings
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]


UNSETTLED = "the mesh does not settle: a delayed value is read across a jump of the state here, or 'mesh: {tol}' is too small"


class Impossible(ConvergenceError):
    """What comes next can be no point of the branch."""


class End(Enum):
    """Why a branch ends, with advice."""

    RANGE = "reached the end of the range; widen 'range' to go on"
    MAX_POINTS = "reached 'max_points'; raise it, or 'step: {max}', to go on"
    STEP_TOO_SMALL = ("the step fell below 'step: {min}'; look at the last orbits for a grazing, a vanishing segment or a sharp "
                      "fold, refine 'mesh', or lower 'step: {min}'")  # fmt: skip
    IMPOSSIBLE = "can go no further with this signature"
    SPECIAL = "stopped at a special point where the signature of the orbit changes"


@dataclass(frozen=True)
class Termination:
    """How one direction of a branch ended."""

    end: End
    detail: str = ""

    def __str__(self) -> str:
        return f"{self.end.value}{f' ({self.detail})' if self.detail else ''}"


class Followed(Problem, Protocol):
    """A problem that a branch can be followed in, on a mesh that may have to change on the way."""

    def metric(self) -> Metric:
        """Return the sizes and weights that lengths are measured with."""
        ...

    def outline(self, x: Array) -> Array:
        """Return the unknowns that no mesh changes."""
        ...

    def outline_index(self) -> NDArray[np.intp]:
        """Return the places of the outline among the unknowns."""
        ...

    def forbids(self, x: Array) -> str:
        """Return why ``x`` can be no point of the branch, in words; empty if it can."""
        ...

    def holds(self, x: Array) -> bool:
        """Whether equations on this mesh make sense at ``x``."""
        ...

    def suits(self, x: Array) -> bool:
        """Whether the mesh holds at the solution ``x`` and is fine enough."""
        ...

    def refit(self, x: Array, others: Sequence[Array], *, solved: bool) -> tuple[Any, Array, list[Array]]:
        """Return the problem on a mesh made for ``x`` (a solution, or a guess), with ``x`` and ``others`` in its unknowns."""
        ...

    def carry(self, other: Any, x: Array) -> Array:
        """Return the unknowns ``x`` of another mesh in this one's."""
        ...

    def rephased(self, x: Array) -> Any:
        """Return the problem with ``x``, a solution, as the reference of its phase and of its next meshes."""
        ...


@dataclass(frozen=True)
class TestFunction:
    """A function along the branch whose zero is a special point of ``kind``; ``stops`` if the branch ends there."""

    __test__ = False
    kind: str
    value: Callable[[Any, Array], float]
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

    problem: Any
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
        For each bounded unknown its place in the outline and its lower and upper bound.
    tests
        Test functions; a change of sign is located and emitted as a special point.
    sign
        Sign given to the arclengths of this direction.
    """
    before: list[float] | None = None
    while state.n_points < settings.max_points:
        state = replace(state, problem=state.problem.rephased(state.x))
        if before is None:
            before = [test.value(state.problem, state.x) for test in tests]
        try:
            reached, step = _advance(state, settings)
        except ConvergenceError as exc:
            return Termination(End.IMPOSSIBLE if isinstance(exc, Impossible) else End.STEP_TOO_SMALL, str(exc))
        crossed = _first_crossing(state.problem.outline(state.x), reached.problem.outline(reached.x), bounds)
        if crossed is not None:
            index, value, fraction = crossed
            try:
                reached = _land(state, reached, index, value, fraction, settings)
            except ConvergenceError:
                # A fold next to the bound: come closer with smaller steps.
                state = replace(state, step=step / 2)
                if state.step < settings.min:
                    return Termination(End.STEP_TOO_SMALL)
                continue
        metric = reached.problem.metric()
        base = reached.problem.carry(state.problem, state.x)
        chord = reached.x - base
        length = np.sqrt(metric.dot(chord, chord))
        after = [test.value(reached.problem, reached.x) for test in tests]
        for test, point, fraction in _specials(state, reached, tests, before, after, settings):
            at = replace(state, problem=point.problem, x=point.x, tangent=np.zeros(0),
                         arclength=state.arclength + sign * fraction * length)  # fmt: skip
            emit(Point(at, test.kind, point.n_iterations))
            if test.stops:
                return Termination(End.SPECIAL, test.kind)
        assert reached.solution is not None
        direction = tangent_of(reached.solution, metric, chord)
        cosine = metric.dot(direction, chord) / length
        state = State(reached.problem, reached.x, direction, state.arclength + sign * length,
                      _next_step(step, reached.n_iterations, cosine, settings), state.n_points + 1)  # fmt: skip
        emit(Point(state, "" if crossed is None else "EP", reached.n_iterations))
        if crossed is not None:
            return Termination(End.RANGE)
        before = after
    return Termination(End.MAX_POINTS)


def _advance(state: State, settings: StepSettings) -> tuple[Located, float]:
    """Return the next point and the step that reached it; halve the step until the corrector converges."""
    step = state.step
    while True:
        try:
            return _step(state, step, settings), step
        except ConvergenceError:
            if step <= settings.min:
                raise
            step = max(0.5 * step, settings.min)


def _step(state: State, step: float, settings: StepSettings) -> Located:
    """Return the point one step on: predict, make the mesh hold, correct, until the mesh suits what is found."""
    problem, base = state.problem, state.x
    predicted = base + step * state.tangent
    _refuse(problem, predicted)
    if not problem.holds(predicted):
        problem, predicted, (base,) = problem.refit(predicted, [base], solved=False)
    guess = predicted
    for _ in range(MAX_MESHES):
        metric = problem.metric()
        solution = correct(problem, predicted, metric.unit(predicted - base), metric, settings.newton, guess)
        _refuse(problem, solution.x)
        moved = solution.x - predicted
        if np.sqrt(metric.dot(moved, moved)) > settings.max_turn * step:
            raise ConvergenceError("the branch turns too sharply for this step", solution.history)
        if problem.suits(solution.x):
            return Located(problem, solution.x, solution)
        problem, guess, (predicted, base) = problem.refit(solution.x, [predicted, base], solved=True)
    raise ConvergenceError(UNSETTLED)


def _refuse(problem: Any, x: Array) -> None:
    reason = problem.forbids(x)
    if reason:
        raise Impossible(reason)


def _land(state: State, reached: Located, index: int, value: float, fraction: float, settings: StepSettings) -> Located:
    """Return the point between two at which outline unknown ``index`` has ``value``."""
    problem = reached.problem
    guess = (1.0 - fraction) * problem.carry(state.problem, state.x) + fraction * reached.x
    if not problem.holds(guess):
        problem, guess, _ = problem.refit(guess, [], solved=False)
    for _ in range(MAX_MESHES):
        place = int(problem.outline_index()[index])
        solution = correct_at(problem, guess, place, value, problem.metric(), settings.newton)
        if problem.suits(solution.x):
            return Located(problem, solution.x, solution)
        problem, guess, _ = problem.refit(solution.x, [], solved=True)
    raise ConvergenceError(UNSETTLED)


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


def _specials(state: State, reached: Located, tests: Sequence[TestFunction], before: Sequence[float], after: Sequence[float],
              settings: StepSettings) -> list[tuple[TestFunction, Located, float]]:  # fmt: skip
    """Return the special points between ``state`` and ``reached`` with their fraction of the step, in order."""
    found = []
    start = Located(state.problem, state.x)
    for test, f0, f1 in zip(tests, before, after, strict=True):
        if f0 * f1 < 0.0 or (f1 == 0.0 and f0 != 0.0):
            point = locate(test.value, start, reached, f0, f1, settings.newton)
            if point is not None:
                found.append((test, *point))
    return sorted(found, key=lambda item: item[2])
