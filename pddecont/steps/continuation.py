"""The ``continue`` step: a branch of periodic orbits in a free parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import grazing, tangency
from pddecont.continuation.arclength import tangent
from pddecont.continuation.branch import Point, State, StepSettings, Termination, TestFunction, follow
from pddecont.errors import ConvergenceError, RunError
from pddecont.orbit.curve import Curve, Sizes, settle, sizes_of
from pddecont.orbit.monitors import Monitor, parse_monitor
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.record import from_rows, mesh_from_row
from pddecont.results.reader import Step as RecordedStep
from pddecont.results.writer import StepWriter
from pddecont.steps.context import Context, mesh_settings, orbit_at, segments_of, settings_text, with_reference
from pddecont.steps.points import orbit_row, orbit_spec
from pddecont.steps.schema import Continue, Step

Array = NDArray[np.float64]
WAYS = {"both": (-1, 1), "down": (-1,), "up": (1,)}


@dataclass(eq=False)
class _Branch:
    """A branch on its way into the results file."""

    context: Context
    step: Step
    body: Continue
    monitors: list[Monitor]
    bounds: list[tuple[float, float]]

    @property
    def settings(self) -> StepSettings:
        s = self.body.step
        return StepSettings(s.initial, s.min, s.max, self.body.max_points)

    def curve(self, problem: OrbitProblem, sizes: Sizes) -> Curve:
        return Curve(problem, sizes, self.context.rule_of(self.step))

    def record(self, writer: StepWriter, point: Point) -> None:
        state = point.state
        assert isinstance(state.problem, Curve)
        row = orbit_row(state.problem.problem, state.x, self.monitors, kind=point.kind, arclength=state.arclength,
                        n_iterations=point.n_iterations, step=state.step, tangent=state.tangent)  # fmt: skip
        writer.append(*row)
        values = ", ".join(f"{name} = {value:.8g}" for name, value in
                           zip(self.body.free, state.x[state.problem.problem.layout.free], strict=True))  # fmt: skip
        self.context.reporter.progress(f"{writer.n} points, {values}{f' {point.kind}' if point.kind else ''}")


def run_continue(context: Context, step: Step, recorded: RecordedStep | None = None) -> None:
    """Follow the branch in each direction asked for, from the start or from where ``recorded`` stopped."""
    plan, body = context.plan, step.continue_
    assert body is not None
    monitors = [parse_monitor(plan.numeric, name, text) for name, text in plan.monitors.items()]
    bounds = [(plan.number(body.range[name][0]), plan.number(body.range[name][1])) for name in body.free]
    branch = _Branch(context, step, body, monitors, bounds)
    ways = WAYS[body.direction]
    start = _start(branch)
    meta = {"free": list(body.free), "directions": len(ways), "settings": settings_text(plan, step),
            "mesh_settings": mesh_settings(plan, step)}  # fmt: skip
    spec = orbit_spec(step.name, "continue", plan.numeric, monitors, meta)
    if recorded is not None and len(recorded):
        states, ended, kept = _resume(branch, recorded, start)
        rows = {name: int(recorded.orbits[f"{name}_end"][kept - 1]) for name in spec.orbits}
        writer = StepWriter(context.path, spec, kept=kept, kept_rows=rows)
    else:
        states, ended = {way: _turned(start, way) for way in ways}, {}
        writer = StepWriter(context.path, spec)
    terminations: list[str] = []
    with writer:
        if writer.n == 0:
            branch.record(writer, Point(start, "", 0))
        curve = start.problem
        assert isinstance(curve, Curve)
        n_outline = len(curve.outline_index())
        places = range(n_outline - len(body.free), n_outline)
        limits = [(place, low, high) for place, (low, high) in zip(places, bounds, strict=True)]
        for i, way in enumerate(ways):
            if way in ended:
                text = ended[way]
            else:
                end = follow(states[way], limits, _tests(), branch.settings, lambda point: branch.record(writer, point), way)
                text = _ending(end, way)
                writer.terminate(text, i)
            terminations.append(text)
    done = context.results().step(step.name)
    special = [(label, i) for i, label in enumerate(done.labels) if label]
    writer.special([label for label, _ in special], [i for _, i in special])
    context.reporter.done(f"{len(done)} points; special: {', '.join(sorted(label for label, _ in special)) or 'none'}; "
                          + "; ".join(terminations))  # fmt: skip


def _ending(end: Termination, way: int) -> str:
    return f"{'down' if way < 0 else 'up'}: {end}"


def _tests() -> list[TestFunction]:
    def clearance(curve: Any, x: Array) -> float:
        return grazing.clearance(curve.problem, x)

    def crossing_rate(curve: Any, x: Array) -> float:
        return tangency.crossing_rate(curve.problem, x)

    return [TestFunction(grazing.KIND, clearance, stops=True), TestFunction(tangency.KIND, crossing_rate, stops=True)]


def _start(branch: _Branch) -> State:
    """Return the branch's start, its tangent towards larger values of the free parameter."""
    context, body, step = branch.context, branch.body, branch.step
    problem, guess = orbit_at(context, step, body.from_)
    try:
        problem, solution = settle(problem, guess, context.rule_of(step))
    except ConvergenceError as exc:
        raise ConvergenceError(f"step '{step.name}': the orbit it starts from does not converge with this step's parameters, "
                               f"delay and mesh: {exc}", exc.history) from exc  # fmt: skip
    problem, x = problem.with_free(solution.x, tuple(body.free))
    for name, (low, high), value in zip(body.free, branch.bounds, x[problem.layout.free], strict=True):
        if not low <= value <= high:
            raise RunError.at(context.plan.source, 0, 0, f"step '{step.name}' starts at {name} = {value:g}, outside its range "
                                                         f"[{low:g}, {high:g}]; widen the range")  # fmt: skip
    curve = branch.curve(problem, sizes_of(problem, x, tuple(high - low for low, high in branch.bounds)))
    towards = np.zeros(len(x))
    towards[problem.layout.free.start] = 1.0
    direction = tangent(curve, x, curve.metric(), towards)
    return State(curve, x, direction, 0.0, branch.settings.initial, 1)


def _turned(start: State, way: int) -> State:
    return State(start.problem, start.x, way * start.tangent, 0.0, start.step, 1)


def _resume(branch: _Branch, recorded: RecordedStep, start: State) -> tuple[dict[int, State], dict[int, str], int]:
    """Return where each direction stands, the directions that have ended, and how many rows to keep."""
    ways = WAYS[branch.body.direction]
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
            states[way] = _state(branch, recorded, rows[-1], start, len(rows) + 1)
            kept = rows[-1] + 1
        else:
            kept = min(kept, 1 + max((i for i in range(len(recorded)) if recorded.points["arclength"][i] * way <= 0), default=0))
        break
    return states, ended, kept


def _ending_word(way: int) -> str:
    return "down:" if way < 0 else "up:"


def _state(branch: _Branch, recorded: RecordedStep, row: int, start: State, n_points: int) -> State:
    """Return the state that a recorded point left."""
    curve = start.problem
    assert isinstance(curve, Curve)
    rows = recorded.orbit(row)
    problem = curve.problem
    mesh = mesh_from_row(rows["mesh"])
    base = OrbitProblem(problem.numeric, segments_of(branch.context.plan, rows["signature"].tobytes().decode()), mesh, problem.delay,
                        recorded.points["parameters"][row], problem.free, problem.n_periods, None, problem.phase,
                        problem.timers)  # fmt: skip
    x = from_rows(base, rows)
    base = with_reference(base, x)
    return State(branch.curve(base, curve.sizes), x, rows["tangent"], float(recorded.points["arclength"][row]),
                 float(recorded.points["step"][row]), n_points)  # fmt: skip
