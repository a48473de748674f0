"""The ``basin`` step: a map of which attractor each of a grid of initial states leads to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.results.attractors import wilson
from pddecont.results.layout import Column, StepSpec
from pddecont.results.reader import Step as RecordedStep
from pddecont.results.writer import StepWriter
from pddecont.simulate.attractors import Attractor, number_of
from pddecont.simulate.basin import Line, basin_line, first_look
from pddecont.simulate.lyapunov import Exponent, known_exponent
from pddecont.simulate.task import Task
from pddecont.simulate.workers import in_order
from pddecont.steps.attractors import attractor_arrays, attractor_columns, attractor_row, describe, no_attractor, recorded_attractor
from pddecont.steps.context import Context, settings_text
from pddecont.steps.integration import clock_of, grid_values, start_of, task_of
from pddecont.steps.plan import Plan
from pddecont.steps.schema import Step
from pddecont.steps.units import units_of

Array = NDArray[np.float64]
# Initial states along each side of the grid that are followed first, to learn which attractors there are.
FIRST_LOOK = 7


def run_basin(context: Context, step: Step, recorded: RecordedStep | None) -> None:
    """Label every cell; rows are attractors as they are found (with a label) and lines of the grid (with their cells' labels)."""
    plan, body = context.plan, step.basin
    assert body is not None
    names, p = list(body.over), plan.step_parameters(step)
    xs, ys = (grid_values(plan, step, name) for name in names)
    spec = StepSpec(
        step.name, "basin", {**attractor_columns(plan), "line": Column("i8")},
        {**attractor_arrays(plan), "label": Column("i4"), "settling": Column("f8")},
        {"parameters": list(plan.model.parameters), "states": list(plan.model.states), "segments": list(plan.model.segments), "over": names,
         "x": xs.tolist(), "y": ys.tolist(), "model": plan.model.name, "units": units_of(plan),
         "settings": settings_text(plan, step)})  # fmt: skip
    task = task_of(plan, step, body, body.initial)
    clock, start = clock_of(plan, body, p), start_of(plan, body.initial, p)
    places = [plan.model.states.index(name) for name in names]

    def states(points: Array) -> Array:
        rows = np.repeat(start.states[None], len(points), axis=0)
        rows[:, places] = points
        return rows

    few_x, few_y = (v[np.unique(np.linspace(0, len(v) - 1, FIRST_LOOK).round().astype(int))] for v in (xs, ys))
    coarse = states(np.stack(np.meshgrid(few_x, few_y), axis=-1).reshape(-1, 2))
    context.reporter.progress("looking for attractors")
    first = tuple(first_look(task, p, clock, coarse, start))
    known = list(first)
    rows = recorded if recorded is not None and len(recorded) > len(first) else None
    done = 0
    if rows is not None:
        done = int(rows.points["line"].max()) + 1
        known = [recorded_attractor(rows, int(i)) for i in np.flatnonzero(rows.points["line"] < 0)]
    kept = len(rows) if rows is not None else 0
    kept_rows = {name: int(rows.orbits[f"{name}_end"][kept - 1]) if rows is not None else 0 for name in spec.orbits}
    counts = np.zeros(0, int) if rows is None else _counts(rows)
    with StepWriter(context.path, spec, kept=kept, kept_rows=kept_rows) as writer:
        if rows is None:
            for attractor in first:
                _write_attractor(writer, task, p, attractor, clock.transient, exponents=body.lyapunov, plan=plan)
        lines = [Line(task, p, clock, states(np.stack([xs, np.full(len(xs), y)], axis=-1)), start, first) for y in ys[done:]]
        for number, result in enumerate(in_order(context.workers, basin_line, lines), done):
            labels = result.labels.copy()
            for cell, attractor in result.strays.items():
                before = len(known)
                labels[cell] = number_of(attractor, known, body.atol, at_section=not clock.period)
                if len(known) > before:
                    _write_attractor(writer, task, p, attractor, clock.transient, exponents=body.lyapunov, plan=plan)
            writer.append({**no_attractor(plan), "line": number},
                          {**{name: np.zeros((0, *c.shape)) for name, c in attractor_arrays(plan).items()}, "label": labels,
                           "settling": result.times})  # fmt: skip
            counts = _added(counts, labels)
            context.reporter.advance(number + 1, len(ys), "lines of the grid")
        text = _summary(known, _added(counts, np.zeros(0, int), len(known)), list(plan.model.segments))
        writer.terminate(text)
    context.reporter.done(text)


def _write_attractor(writer: StepWriter, task: Task, p: Array, attractor: Attractor, duration: float, *, exponents: bool,
                     plan: Plan) -> None:  # fmt: skip
    exponent = Exponent()
    if exponents and not attractor.failed:
        simulator = task.simulator()
        exponent = known_exponent(simulator, simulator.values(p), attractor, duration)
    points, arrays = attractor_row(attractor, p, exponent)
    nothing = {"label": np.zeros(0, int), "settling": np.zeros(0)}
    writer.append({**points, "line": -1}, {**arrays, **nothing})


def _counts(rows: RecordedStep) -> NDArray[np.int64]:
    return np.bincount(rows.orbits["label"]).astype(np.int64)


def _added(counts: NDArray[np.int64], labels: NDArray[np.int64], least: int = 0) -> NDArray[np.int64]:
    more = np.bincount(labels, minlength=max(len(counts), least))
    more[: len(counts)] += counts
    return more.astype(np.int64)


def _summary(known: list[Attractor], counts: NDArray[np.int64], segments: list[str]) -> str:
    total, parts, number = int(counts.sum()), [], 0
    for attractor, count in zip(known, counts, strict=True):
        low, high = wilson(int(count), total)
        number += not attractor.failed
        name = f"A{number}" if not attractor.failed else "none"
        share = f"{100 * count / total:.2f} % ({100 * low:.2f} to {100 * high:.2f})"
        parts.append(f"{name} ({describe(attractor, segments)}): {share}")
    return f"{total} initial states; " + "; ".join(parts)
