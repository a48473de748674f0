"""Following a branch: predict, correct, watch the test functions, adapt the step, stop with a reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric, Problem, correct, correct_at, tangent_of
from pddecont.continuation.locate import MAX_MESHES, Chord, Located
from pddecont.continuation.newton import NewtonSettings
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
AT_START = 1e-4
MAX_CUTS = 10
NEAR = 0.02
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
    INVALID = ("the orbit stops being a motion of the model without a special point that was located; take smaller steps "
               "('step: {max}'), or start anew from a simulation beyond")  # fmt: skip
    RESONANCE = "the curve ends where its pair of multipliers meets on the real axis"


@dataclass(frozen=True)
class Termination:
    """How one direction of a branch ended; ``lost`` counts the changes of stability that no special point accounts for."""

    end: End
    detail: str = ""
    lost: int = 0

    def __str__(self) -> str:
        lost = f"; WARNING: {self.lost} change{'s'[: self.lost - 1]} of stability not located: take smaller steps" if self.lost else ""
        return f"{self.end.value}{f' ({self.detail})' if self.detail else ''}{lost}"


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
    """A function along the branch whose zero is a special point of ``kind``; ``stops`` if the branch ends there, with ``end``.

    ``note`` says more of the point. ``meeting`` finds the point itself between two orbits with a change of sign, or None: where a branch
    meets another one, no orbit between the two can be found on the way and no census can be trusted.
    """

    __test__ = False
    kind: str
    value: Callable[[Located], float]
    stops: bool = False
    note: str = ""
    end: End = End.SPECIAL
    meeting: Callable[[Located, Located], Located | None] | None = None


Counts = tuple[int, ...]


@dataclass(frozen=True)
class Census:
    """Whole numbers that change only at special points, such as how many multipliers lie outside the unit circle.

    ``explain(before, after)`` returns the test functions whose zeros account for a change, or None if several changes have come
    together and the step must be cut.
    """

    count: Callable[[Located], Counts]
    explain: Callable[[Counts, Counts], Sequence[TestFunction] | None]


@dataclass(frozen=True)
class Watch:
    """What is watched along a branch; ``objection`` says why a point is none of the problem's solutions, empty if it is one."""

    tests: Sequence[TestFunction] = ()
    census: Census | None = None
    objection: Callable[[Located], str] = lambda _: ""


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
           emit: Callable[[Point], None], sign: int) -> Termination:  # fmt: skip
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
    """
    before: _Seen | None = None
    first, lost = True, 0
    while state.n_points < settings.max_points:
        state = replace(state, problem=state.problem.rephased(state.x))
        start = Located(state.problem, state.x, None, state.tangent)
        before = before or _look(start, watch)
        try:
            reached, step = _advance(state, settings)
        except ConvergenceError as exc:
            return Termination(End.IMPOSSIBLE if isinstance(exc, Impossible) else End.STEP_TOO_SMALL, str(exc), lost)
        crossed = _first_crossing(state.problem.outline(state.x), reached.problem.outline(reached.x), bounds)
        if crossed is not None:
            index, value, fraction = crossed
            try:
                reached = _land(state, reached, index, value, fraction, settings)
            except ConvergenceError:
                # A fold next to the bound: come closer with smaller steps.
                state = replace(state, step=step / 2)
                if state.step < settings.min:
                    return Termination(End.STEP_TOO_SMALL, "", lost)
                continue
        metric = reached.problem.metric()
        base = reached.problem.carry(state.problem, state.x)
        chord = reached.x - base
        length = np.sqrt(metric.dot(chord, chord))
        assert reached.solution is not None
        direction = tangent_of(reached.solution, metric, chord)
        reached = replace(reached, direction=direction)
        after = _look(reached, watch)
        specials, unexplained = _specials(Chord(start, reached, settings.newton), watch, before, after, AT_START if first else 0.0)
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
        emit(Point(state, "" if crossed is None else "EP", reached.n_iterations))
        if after.objection and not before.objection:
            return Termination(End.INVALID, after.objection, lost)
        if crossed is not None:
            return Termination(End.RANGE, "", lost)
        before, first = after, False
    return Termination(End.MAX_POINTS, "", lost)


def _advance(state: State, settings: StepSettings) -> tuple[Located, float]:
    """Return the next point and the step that reached it; halve the step until the corrector converges."""
    step = state.step
    while True:
        try:
            return _step(state, step, settings), step
        except ConvergenceError as exc:
            # An impossible point is come near to, not crept up to.
            least = max(settings.min, NEAR * settings.initial) if isinstance(exc, Impossible) else settings.min
            if step <= least:
                raise
            step = max(0.5 * step, least)


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


@dataclass(frozen=True)
class _Seen:
    """What the watch says of a point."""

    values: tuple[float, ...]
    counts: Counts
    objection: str


def _look(point: Located, watch: Watch) -> _Seen:
    counts = watch.census.count(point) if watch.census else ()
    return _Seen(tuple(test.value(point) for test in watch.tests), counts, watch.objection(point))


@dataclass(frozen=True, eq=False)
class _Found:
    """A special point at a fraction of a step."""

    test: TestFunction
    point: Located
    fraction: float


def _specials(chord: Chord, watch: Watch, before: _Seen, after: _Seen, from_: float) -> tuple[list[_Found], int]:
    """Return the special points on a step in order, and the number of changes in the census that none of them explains.

    Where two fall together the one that ends the branch comes first.

    Those before the fraction ``from_`` are the point that the branch starts from.
    """
    found = []
    for test, f0, f1 in zip(watch.tests, before.values, after.values, strict=True):
        if f0 * f1 < 0.0 or (f1 == 0.0 and f0 != 0.0):
            found += _zero(chord, test, 0.0, 1.0, f0, f1)
    found, lost = [f for f in found if f.fraction >= from_], 0
    if watch.census is not None and not any(f.test.meeting for f in found):
        # What lies beyond a point that ends the branch counts for nothing.
        last = min((f.fraction for f in found if f.test.stops), default=1.0)
        counts = after.counts if last == 1.0 else watch.census.count(chord.at(last))
        counted = _counted(chord, watch.census, 0.0, last, before.counts, counts, MAX_CUTS)
        found += [f for f in counted if f is not None]
        # At the start of a branch the special point that it comes from may still show.
        lost = 0 if from_ else len([f for f in counted if f is None])
    order = sorted((f for f in found if f.fraction >= from_), key=lambda f: (round(f.fraction, 6), not f.test.stops, f.fraction))
    return order, lost


def _zero(chord: Chord, test: TestFunction, low: float, high: float, f_low: float, f_high: float) -> list[_Found]:
    if test.meeting is not None:
        met = test.meeting(chord.at(low), chord.at(high))
        return [] if met is None else [_Found(test, met, low + (high - low) * f_low / (f_low - f_high))]
    fraction = chord.zero(test.value, low, high, f_low, f_high)
    return [] if fraction is None else [_Found(test, chord.at(fraction), fraction)]


def _counted(chord: Chord, census: Census, low: float, high: float, before: Counts, after: Counts, cuts: int) -> list[_Found | None]:
    """Return the special points that account for a change of the census, cutting the step where several come together.

    None stands for a change that could not be explained.
    """
    if before == after:
        return []
    tests = census.explain(before, after)
    if tests is not None:
        ends = [(test.value(chord.at(low)), test.value(chord.at(high))) for test in tests]
        # A test function may not exist all along: no real multiplier at one end, say. Then the step is cut too.
        if all(f_low * f_high <= 0.0 for f_low, f_high in ends):
            result: list[_Found | None] = []
            for test, (f_low, f_high) in zip(tests, ends, strict=True):
                result += _zero(chord, test, low, high, f_low, f_high) or [None]
            return result
    if cuts == 0:
        return [None]
    middle = 0.5 * (low + high)
    try:
        between = census.count(chord.at(middle))
    except ConvergenceError:
        return [None]
    return [*_counted(chord, census, low, middle, before, between, cuts - 1),
            *_counted(chord, census, middle, high, between, after, cuts - 1)]  # fmt: skip
