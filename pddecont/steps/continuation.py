"""The ``continue`` step: a branch of periodic orbits in one free parameter, or a curve of special points in two."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import tangency
from pddecont.bifurcation.codim2 import without_critical
from pddecont.bifurcation.conditioned import SpecialCurve
from pddecont.bifurcation.side import side_of
from pddecont.continuation.branch import Point, State, StepSettings, follow
from pddecont.continuation.ending import End, Termination
from pddecont.errors import ConvergenceError
from pddecont.orbit.curve import Curve
from pddecont.orbit.delays import DELAYS
from pddecont.orbit.guess import timers_of
from pddecont.orbit.monitors import Monitor, parse_monitor
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.record import from_rows, mesh_from_row
from pddecont.results.reader import Step as RecordedStep
from pddecont.results.writer import StepWriter
from pddecont.stability.multipliers import LOST_ADVICE, TRIVIAL_ERROR
from pddecont.steps.context import Context, choice_of, known_multipliers, mesh_settings, segments_of, settings_text, with_reference
from pddecont.steps.next_signature import go_on
from pddecont.steps.points import orbit_row, orbit_spec
from pddecont.steps.schema import Step
from pddecont.steps.start import Start, Task, condition_of, start_of
from pddecont.steps.units import units_of
from pddecont.steps.watch import followed, watch_of

Array = NDArray[np.float64]
WAYS = {"both": (-1, 1), "down": (-1,), "up": (1,)}
MAX_SIGNATURES = 100


@dataclass(eq=False)
class _Branch:
    """A branch on its way into the results file."""

    task: Task
    monitors: list[Monitor]
    writer: StepWriter
    last: Point | None = field(default=None)
    ordinary: State | None = field(default=None)

    @property
    def settings(self) -> StepSettings:
        """Return what decides the branch's numbers."""
        s = self.task.body.step
        return StepSettings(s.initial, s.min, s.max, self.task.body.max_points)

    def limits(self, state: State) -> list[tuple[int, float, float]]:
        """Return the free parameters' places in the outline with their bounds."""
        n, bounds = len(state.problem.outline_index()), self.task.bounds
        return [(n - len(bounds) + i, low, high) for i, (low, high) in enumerate(bounds)]

    def record(self, point: Point) -> None:
        """Write a point to the file."""
        state, known = point.state, self.task.known
        problem = state.problem.problem
        side = side_of(state.problem, state.x) if isinstance(state.problem, SpecialCurve) else None
        of_curve = state.problem.condition.kind if isinstance(state.problem, SpecialCurve) else point.kind
        row = orbit_row(problem, state.x, self.monitors, kind=point.kind, arclength=state.arclength, n_iterations=point.n_iterations,
                        step=state.step, tangent=state.tangent, note=point.note, side=side, widths=self.task.widths,
                        stability=without_critical(known(problem, state.x), of_curve) if known else None)  # fmt: skip
        self.writer.append(*row)
        self.last = point
        if not point.kind or point.kind == "EP":
            self.ordinary = state
        values = ", ".join(f"{name} = {value:.8g}" for name, value in
                           zip(self.task.body.free, state.x[problem.layout.free], strict=True))  # fmt: skip
        self.task.context.reporter.progress(f"{self.writer.n} points, {values}{f' {point.kind}' if point.kind else ''}")

    def follow(self, state: State, way: int) -> str:
        """Follow one direction through all its signatures; return how it ended."""
        rule = self.task.context.rule_of(self.task.step)
        for _ in range(MAX_SIGNATURES):
            self.last, self.ordinary = Point(state, "", 0), state
            end = follow(state, self.limits(state), watch_of(self.task, state), self.settings, self.record, way, DELAYS)
            if end.end not in (End.SPECIAL, End.IMPOSSIBLE) or self.task.body.signature_change == "stop":
                break
            if end.end is End.IMPOSSIBLE and not self.task.asks(tangency.KIND):
                break
            try:
                following = go_on(end, self.last, self.ordinary, rule, self.record, way)
            except ConvergenceError as exc:
                return self.ending(end, way) + f"; the orbit of the next signature was not found: {exc}"
            if following is None:
                break
            # A signature may be short-lived: begin it as a branch is begun.
            state = replace(following, step=min(following.step, self.task.body.step.initial))
        note = self.last.note if self.last is not None else ""
        advice = f": {note}; beyond, they happen in another order: start anew from a simulation there" if tangency.MEETS in note else ""
        return self.ending(end, way) + advice

    def ending(self, end: Termination, way: int) -> str:
        """Return how a direction ended, with the signatures that it went through."""
        done = self.task.context.recorded(self.task.step.name)
        names: list[str] = []
        for i in done.order[::way]:
            if done.points["arclength"][i] * way >= 0 and done.points["kind"][i] in (b"", b"EP"):
                name = done.orbit(i)["signature"].tobytes().decode()
                names += [name] if names[-1:] != [name] else []
        through = f", through the signatures [{'], ['.join(names)}]" if len(names) > 1 else ""
        told = replace(end, where=self.bound()) if end.end is End.RANGE else end
        return f"{'down' if way < 0 else 'up'}: {told}{through}"

    def bound(self) -> str:
        """Return the free parameter whose range ends at the last point, and there: ``A = 0.05``."""
        assert self.last is not None
        values = self.last.state.x[self.last.state.problem.problem.layout.free]
        return ", ".join(f"{name} = {end:.8g}" for name, value, ends in zip(self.task.body.free, values, self.task.bounds, strict=True)
                         for end in ends if abs(value - end) <= 1e-9 * (ends[1] - ends[0]))  # fmt: skip


def run_continue(context: Context, step: Step, recorded: RecordedStep | None = None) -> None:
    """Follow the branch in each direction asked for, from the start or from where ``recorded`` stopped."""
    plan, body = context.plan, step.continue_
    assert body is not None
    monitors = [parse_monitor(plan.numeric, name, text) for name, text in plan.monitors.items()]
    named = {m.name: m for m in monitors}
    users = tuple(parse_monitor(plan.numeric, name, text, named) for name, text in body.events_along.items())
    bounds = tuple((plan.number(body.range[name][0]), plan.number(body.range[name][1])) for name in body.free)
    task = Task(context, step, body, bounds, users, known_multipliers(body.stability))
    start = start_of(task)
    if task.known is not None and task.known(start.state.problem.problem, start.state.x).lost:
        raise ConvergenceError(f"step '{step.name}': {LOST_ADVICE}, or leave 'stability' out")
    ways = ways_of(task, start)
    meta = {"free": list(body.free), "directions": len(ways), "settings": settings_text(plan, step), "curve": start.curve,
            "mesh_settings": mesh_settings(plan, step), "units": units_of(plan), **choice_of(plan, step)}  # fmt: skip
    spec = orbit_spec(step.name, "continue", plan.numeric, monitors, meta)
    if recorded is not None and len(recorded):
        states, ended, kept = _resume(task, recorded, start.state, ways)
        rows = {name: int(recorded.orbits[f"{name}_end"][kept - 1]) for name in spec.orbits}
        writer = StepWriter(context.path, spec, kept=kept, kept_rows=rows)
    else:
        states, ended = {way: _turned(start.state, way) for way in ways}, {}
        writer = StepWriter(context.path, spec)
    branch = _Branch(task, monitors, writer)
    terminations: list[str] = []
    with writer:
        if writer.n == 0:
            branch.record(Point(start.state, "", 0))
        for i, way in enumerate(ways):
            text = ended.get(way) or branch.follow(states[way], way)
            if way not in ended:
                writer.terminate(text, i)
            terminations.append(text)
    done = context.recorded(step.name)
    errors = done.points["trivial_error"]
    poor = np.any(errors > TRIVIAL_ERROR)
    doubt = f"; WARNING: the trivial multiplier is off by up to {np.nanmax(errors):.1e}: refine 'mesh'" if poor else ""
    context.reporter.done(f"{len(done)} points; special: {', '.join(sorted(label for label in done.labels if label)) or 'none'}; "
                          + "; ".join(terminations) + doubt)  # fmt: skip


def ways_of(task: Task, start: Start) -> tuple[int, ...]:
    """Return the signs of the directions that the branch is followed in."""
    return (1,) if start.one_way else WAYS[task.body.direction]


def _turned(start: State, way: int) -> State:
    return State(start.problem, start.x, way * start.tangent, 0.0, start.step, 1)


def _resume(task: Task, recorded: RecordedStep, start: State, ways: tuple[int, ...]) -> tuple[dict[int, State], dict[int, str], int]:
    """Return where each direction stands, the directions that have ended, and how many rows to keep."""
    ended = {way: text for way in ways for text in recorded.termination if text.startswith(_ending_word(way))}
    states = {way: _turned(start, way) for way in ways}
    kept = len(recorded)
    for way in ways:
        if way in ended:
            continue
        rows = [i for i in range(len(recorded)) if recorded.points["arclength"][i] * way > 0]
        while rows and recorded.points["kind"][rows[-1]]:
            rows.pop()
        if rows:
            ordinary = sum(not recorded.points["kind"][i] for i in rows)
            states[way] = _state(task, recorded, rows[-1], start, ordinary + 1)
            kept = rows[-1] + 1
        else:
            kept = min(kept, 1 + max((i for i in range(len(recorded)) if recorded.points["arclength"][i] * way <= 0), default=0))
        break
    return states, ended, kept


def _ending_word(way: int) -> str:
    return "down:" if way < 0 else "up:"


def _state(task: Task, recorded: RecordedStep, row: int, start: State, n_points: int) -> State:
    """Return the state that a recorded point left."""
    of_start = start.problem.problem
    rows = recorded.orbit(row)
    mesh, segments = mesh_from_row(rows["mesh"]), segments_of(task.context.plan, rows["signature"].tobytes().decode())
    p, n = recorded.points["parameters"][row], mesh.n_segments
    base = OrbitProblem(of_start.numeric, segments, mesh, of_start.delay, p, of_start.free, int(recorded.points["n_periods"][row]), None,
                        float(recorded.points["phase"][row]), timers_of(of_start.numeric, segments, p, rows["unknowns"][:n]))  # fmt: skip
    x = from_rows(base, rows)
    base = with_reference(base, x)
    special = start.problem if isinstance(start.problem, SpecialCurve) else None
    plain = Curve(base, (special.curve if special else start.problem).sizes, task.context.rule_of(task.step))
    curve = SpecialCurve(plain, condition_of(task, plain, x, special.condition.kind, followed(special))) if special else plain
    return State(curve, x, rows["tangent"], float(recorded.points["arclength"][row]), float(recorded.points["step"][row]), n_points)
