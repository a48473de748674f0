"""Where a branch starts: an orbit, a special point, the other branch at a special point, the orbits after a grazing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import branch_point, fold, grazing, period_doubling, signature, tangency, torus, user
from pddecont.bifurcation.conditioned import Condition, SpecialCurve
from pddecont.continuation.arclength import correct, tangent, tangent_of
from pddecont.continuation.branch import State
from pddecont.continuation.newton import NewtonSettings
from pddecont.continuation.settling import settled
from pddecont.errors import ConvergenceError, InputError, RunError, SignatureError
from pddecont.orbit.curve import Curve, settle, sizes_of
from pddecont.orbit.monitors import Monitor
from pddecont.orbit.problem import OrbitProblem
from pddecont.results.reader import Step as RecordedStep
from pddecont.stability.multipliers import Known
from pddecont.steps.context import Context, orbit_at, source_step
from pddecont.steps.orbit import is_rotation
from pddecont.steps.schema import Continue, Step

Array = NDArray[np.float64]
SLOW = 1e-6
SHORT = 1e-6
EDGE = 1e-9
STILL = 1e-6


@dataclass(frozen=True, eq=False)
class Task:
    """A ``continue`` step with what it needs: bounds of its free parameters, user functions, multipliers."""

    context: Context
    step: Step
    body: Continue
    bounds: tuple[tuple[float, float], ...]
    users: tuple[Monitor, ...]
    known: Known | None

    def asks(self, kind: str) -> bool:
        """Whether the step asks for special points of ``kind``."""
        return self.body.detect is None or kind in self.body.detect

    @property
    def widths(self) -> tuple[float, ...]:
        """Widths of the free parameters' ranges."""
        return tuple(high - low for low, high in self.bounds)


@dataclass(frozen=True, eq=False)
class Start:
    """A branch's first point with its direction, and what kind of special point it follows (empty: orbits).

    ``one_way`` where the branch begins at its first point, or goes on as its own mirror image.
    """

    state: State
    curve: str = ""
    one_way: bool = False


def start_of(task: Task) -> Start:
    """Return where the branch starts, its tangent towards larger values of the first free parameter."""
    problem, guess = orbit_at(task.context, task.step, task.body.from_)
    kind, note, recorded, row = _origin(task)
    if len(task.body.free) == 2:
        start = _advised(lambda: _special(task, problem, guess, kind, note), task, f"the {kind or 'special'} point that it follows")
    elif task.body.branch == "switch":
        start = _switched(task, problem, guess, kind, recorded, row)
    elif task.body.signature is not None and not is_rotation([s.name for s in problem.segments], task.body.signature):
        start = _advised(lambda: _entered(task, problem, guess, kind), task, "the orbit after the grazing")
    else:
        start = _plain(task, problem, guess)
    values = start.state.x[start.state.problem.problem.layout.free]
    for name, (low, high), value in zip(task.body.free, task.bounds, values, strict=True):
        if not low - EDGE * (high - low) <= value <= high + EDGE * (high - low):
            raise _wrong(task, f" starts at {name} = {value:g}, outside its range "
                                                              f"[{low:g}, {high:g}]; widen the range")  # fmt: skip
    return start


def _advised(begin: Callable[[], Start], task: Task, what: str) -> Start:
    """Return what ``begin`` finds; a failure says what was tried and what usually helps."""
    try:
        return begin()
    except ConvergenceError as exc:
        raise ConvergenceError(f"step '{task.step.name}': {what} does not converge: {exc}. What usually helps: the mesh and delay of the "
                               "step that found the point, a finer mesh there, the other free parameter first",
                               exc.history) from exc  # fmt: skip


def _origin(task: Task) -> tuple[str, str, RecordedStep, int]:
    """Return kind and note of the point that the step starts from, and where it is recorded."""
    recorded, row = source_step(task.context, task.body.from_)
    note = recorded.points["note"][row].decode() if "note" in recorded.points else ""
    return recorded.points["kind"][row].decode(), note, recorded, row


def _state(task: Task, problem: Curve | SpecialCurve, x: Array, direction: Array) -> State:
    return State(problem, x, direction, 0.0, task.body.step.initial, 1)


def _forward(curve: Curve, x: Array) -> Array:
    """Return the tangent towards larger values of the free parameter."""
    towards = np.zeros(len(x))
    towards[curve.problem.layout.free.start] = 1.0
    return tangent(curve, x, curve.metric(), towards)


def _curve(task: Task, problem: OrbitProblem, x: Array) -> tuple[Curve, Array]:
    problem, x = problem.with_free(x, tuple(task.body.free))
    return Curve(problem, sizes_of(problem, x, task.widths), task.context.rule_of(task.step)), x


def _settled(task: Task, problem: OrbitProblem, guess: Array) -> tuple[OrbitProblem, Array]:
    try:
        problem, solution = settle(problem, guess, task.context.rule_of(task.step))
    except ConvergenceError as exc:
        raise ConvergenceError(f"step '{task.step.name}': the orbit it starts from does not converge with this step's parameters, "
                               f"delay and mesh: {exc}. What usually helps: the mesh and delay of the step it comes from, a point "
                               "farther from a fold or a grazing", exc.history) from exc  # fmt: skip
    return problem, solution.x


def _plain(task: Task, problem: OrbitProblem, guess: Array) -> Start:
    curve, x = _curve(task, *_settled(task, problem, guess))
    return Start(_state(task, curve, x, _forward(curve, x)))


def _switched(task: Task, problem: OrbitProblem, guess: Array, kind: str, recorded: RecordedStep, row: int) -> Start:
    rule = task.context.rule_of(task.step)
    if kind == period_doubling.KIND:
        problem, x = _settled(task, problem, guess)
        # Taken twice the orbit has the multiplier +1, so it is not solved for again before the branch has left it.
        twice, x, direction = period_doubling.doubled(problem, x, rule)
        curve, x = _curve(task, twice, x)
        return Start(_state(task, curve, x, curve.metric().unit(np.append(direction, np.zeros(len(task.body.free))))), one_way=True)
    if kind == branch_point.KIND:
        curve, x = _curve(task, problem, guess)
        along = recorded.orbit(row)["tangent"]
        if len(along) != len(x):
            raise _wrong(task, ": a branch is switched at a BP point on the mesh and with the free parameter of the step that found it")
        return Start(_state(task, curve, x, branch_point.other_branch(curve, x, along)))
    raise _wrong(task, f": 'branch: switch' starts from a PD or BP point, not from {_named(kind)}")


def _entered(task: Task, problem: OrbitProblem, guess: Array, kind: str) -> Start:
    assert task.body.signature is not None
    names = [s.name for s in problem.segments]
    if kind != grazing.KIND:
        raise SignatureError(f"step '{task.step.name}' asks for the signature [{', '.join(task.body.signature)}], but its start runs "
                             f"through [{', '.join(names)}]; another signature begins at a GR point")  # fmt: skip
    curve, x = _curve(task, problem, guess)
    entered = signature.enter(curve, x, task.context.rule_of(task.step))
    found = [s.name for s in entered.curve.problem.segments]
    if not is_rotation(found, task.body.signature):
        raise SignatureError(f"step '{task.step.name}' asks for the signature [{', '.join(task.body.signature)}], but the grazing leads to "
                             f"[{', '.join(found)}]")  # fmt: skip
    return Start(_state(task, entered.curve, entered.x, entered.tangent), one_way=True)


def _special(task: Task, problem: OrbitProblem, guess: Array, kind: str, note: str) -> Start:
    curve, x = _curve(task, problem, guess)
    special, solution = settled(SpecialCurve(curve, condition_of(task, curve, x, kind, note)), x,
                                lambda c, g: correct(c, g, c.along(g), c.metric(), NewtonSettings()))  # fmt: skip
    direction = tangent_of(solution, special.metric(), special.along(solution.x))
    moves = direction[special.problem.layout.free] / np.array(task.widths)
    forward = next((float(np.sign(m)) for m in moves if abs(m) > STILL * np.max(np.abs(moves))), 1.0)
    return Start(_state(task, special, solution.x, forward * direction), kind)


def condition_of(task: Task, curve: Curve, x: Array, kind: str, note: str) -> Condition:
    """Return what defines a special point of ``kind``."""
    known = task.known or Known()
    problem = curve.problem
    if kind == fold.KIND:
        return fold.fold_at(curve, x)
    if kind == period_doubling.KIND:
        return period_doubling.Doubling(known).framed(curve, x)
    if kind == torus.KIND:
        own = known(problem, x).own
        upper = own[own.imag > 0.0]
        if not len(upper):
            raise ConvergenceError("no complex pair of multipliers is left at this point")
        return torus.Torus(known, complex(upper[np.argmin(np.abs(np.abs(upper) - 1.0))]))
    if kind == user.KIND:
        monitor = next((m for m in task.users if m.name == note), None)
        if monitor is None:
            raise _wrong(task, f" starts where the user function '{note}' is zero; give it in this step's 'events_along' too")
        return user.UserFunction(monitor)
    if kind == tangency.KIND:
        durations = x[problem.layout.durations]
        if np.min(durations) < SHORT * np.sum(durations):
            s = int(np.argmin(durations))
            return tangency.Coincidence(s, float(durations[s]))
        met = [m for m in tangency.meetings(problem) if abs(m.at(problem, x)) < SLOW]
        if tangency.MEETS in note and met:
            return min(met, key=lambda m: abs(m.at(problem, x)))
        rates = tangency.crossing_rates(problem, x)
        if np.any(np.abs(rates) < SLOW * np.nanmax(np.abs(rates), initial=0.0)) or np.nanmin(np.abs(rates), initial=1.0) < SLOW:
            return tangency.Tangency(int(np.nanargmin(np.abs(rates))))
    if kind in (grazing.KIND, tangency.KIND):
        condition = grazing.graze_at(problem, x)
        if condition is None:
            raise ConvergenceError("no event function has an extremum inside a segment on this mesh; refine 'mesh'")
        return condition
    raise _wrong(task, " has two free parameters: it follows a special point (LP, PD, TR, GR, VS or UF) and cannot start from "
                       f"{_named(kind)}")  # fmt: skip


def _wrong(task: Task, text: str) -> InputError:
    return RunError.at(task.context.plan.source, 0, 0, f"step '{task.step.name}'{text}")


def _named(kind: str) -> str:
    return f"a {kind} point" if kind else "an ordinary point"
