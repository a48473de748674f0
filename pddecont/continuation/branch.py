"""Following a branch: predict, correct, watch the test functions, adapt the step, stop with a reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric, Problem, correct, correct_at, tangent_of
from pddecont.continuation.ending import End, Termination
from pddecont.continuation.locate import Chord, Located
from pddecont.continuation.margin import Margins
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.settling import MAX_MESHES, UNSETTLED, settled
from pddecont.continuation.special import Seen, Watch, look, specials_between
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
NO_MARGINS = Margins()
AT_START = 1e-4
NEAR = 0.02


class Impossible(ConvergenceError):
    """What comes next can be no point of the branch."""


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
    """One point of a branch; ``kind`` is empty for an ordinary one, ``note`` says more of a special one."""

    state: State
    kind: str
    n_iterations: int
    note: str = ""


def follow(state: State, bounds: Sequence[tuple[int, float, float]], watch: Watch, settings: StepSettings,
           emit: Callable[[Point], None], sign: int, margins: Margins = NO_MARGINS) -> Termination:  # fmt: skip
    """Follow a branch from ``state`` along its tangent, handing each point to ``emit``; return how it ended.

    Parameters
    ----------
    state
        A point on the branch and the direction to go.
    bounds
        For each bounded unknown its place in the outline and its lower and upper bound.
    watch
        Test functions, whose changes of sign are located and emitted as special points, and a census, whose changes they explain.
    sign
        Sign given to the arclengths of this direction.
    margins
        What cannot become negative; the branch ends where one is used up.
    """
    before: Seen | None = None
    first, lost = True, 0
    while state.n_points < settings.max_points:
        state = replace(state, problem=state.problem.rephased(state.x))
        start = Located(state.problem, state.x, None, state.tangent)
        before = before or look(start, watch)
        ending = margins.used_up(state.problem, state.x, state.tangent)
        if ending:
            return Termination(End.LIMIT, ending, lost)
        try:
            reached, step = _advance(state, settings, margins)
        except ConvergenceError as exc:
            return Termination(End.IMPOSSIBLE if isinstance(exc, Impossible) else End.STEP_TOO_SMALL, str(exc), lost)
        crossed = _first_crossing(state.problem.outline(state.x), reached.problem.outline(reached.x), bounds)
        if crossed is not None:
            index, value, fraction = crossed
            try:
                reached = _land(state, reached, index, value, fraction, settings)
            except ConvergenceError as exc:
                # A fold next to the bound: come closer with smaller steps.
                state = replace(state, step=step / 2)
                if state.step < settings.min:
                    return Termination(End.STEP_TOO_SMALL, str(exc), lost)
                continue
        metric = reached.problem.metric()
        base = reached.problem.carry(state.problem, state.x)
        chord = reached.x - base
        length = np.sqrt(metric.dot(chord, chord))
        assert reached.solution is not None
        direction = tangent_of(reached.solution, metric, chord)
        reached = replace(reached, direction=direction)
        after = look(reached, watch)
        specials, unexplained = specials_between(Chord(start, reached, settings.newton), watch, before, after, AT_START if first else 0.0)
        lost += unexplained
        for found in specials:
            curve = found.point.problem
            at = replace(state, problem=curve, x=found.point.x, tangent=curve.metric().unit(found.point.tangent),
                         arclength=state.arclength + sign * found.fraction * length)  # fmt: skip
            emit(Point(at, found.test.kind, found.point.n_iterations, found.test.note))
            if found.test.stops:
                return Termination(found.test.end, found.test.kind, lost)
        cosine = metric.dot(direction, chord) / length
        state = State(reached.problem, reached.x, direction, state.arclength + sign * length,
                      _next_step(step, reached.n_iterations, cosine, settings), state.n_points + 1)  # fmt: skip
        ending = margins.used_up(state.problem, state.x, direction)
        emit(Point(state, "EP" if ending or crossed is not None else "", reached.n_iterations))
        if after.objection and not before.objection:
            return Termination(End.INVALID, after.objection, lost)
        if ending:
            return Termination(End.LIMIT, ending, lost)
        if crossed is not None:
            return Termination(End.RANGE, "", lost)
        before, first = after, False
    return Termination(End.MAX_POINTS, "", lost)


def _advance(state: State, settings: StepSettings, margins: Margins) -> tuple[Located, float]:
    """Return the next point and the step that reached it; halve the step until the corrector converges."""
    step = state.step
    while True:
        try:
            return _step(state, step, settings, margins), step
        except ConvergenceError as exc:
            # An impossible point is come near to, not crept up to.
            least = max(settings.min, NEAR * settings.initial) if isinstance(exc, Impossible) else settings.min
            if step <= least:
                raise
            step = max(0.5 * step, least)


def _step(state: State, step: float, settings: StepSettings, margins: Margins) -> Located:
    """Return the point one step on: predict, make the mesh hold, correct, until the mesh suits what is found."""
    problem, base = state.problem, state.x
    predicted = base + step * state.tangent
    _refuse(problem, predicted)
    if margins.overdrawn(problem, predicted):
        last = margins.end(problem, base, predicted, settings.newton)
        _refuse(last.problem, last.x)
        return last
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
        if margins.overdrawn(problem, solution.x):
            raise ConvergenceError("the step leads past the end of the branch", solution.history)
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
    guess = (1.0 - fraction) * reached.problem.carry(state.problem, state.x) + fraction * reached.x

    def solve(problem: Any, from_: Array) -> Solution:
        return correct_at(problem, from_, int(problem.outline_index()[index]), value, problem.metric(), settings.newton)

    problem, solution = settled(reached.problem, guess, solve)
    return Located(problem, solution.x, solution)


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
