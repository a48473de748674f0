"""The ``sweep`` step: brute-force diagrams over one or two parameters."""

from __future__ import annotations

import itertools
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from pddecont.results.layout import Column, StepSpec
from pddecont.results.reader import Step as RecordedStep
from pddecont.results.writer import StepWriter
from pddecont.simulate.sweep import Cell, Chunk, sweep_chunk
from pddecont.simulate.task import Start
from pddecont.simulate.workers import in_order
from pddecont.steps.attractors import attractor_arrays, attractor_columns, attractor_row
from pddecont.steps.context import Context, settings_text
from pddecont.steps.integration import clock_of, grid_values, start_of, task_of
from pddecont.steps.plan import Plan
from pddecont.steps.schema import Section, Step, Sweep
from pddecont.steps.units import units_of

Array = NDArray[np.float64]
# Motions in a chunk of work that is not carried along.
CHUNK = 8


def run_sweep(context: Context, step: Step, recorded: RecordedStep | None) -> None:
    """Find the attractors at every parameter point; those of an unfinished step are kept."""
    plan, body = context.plan, step.sweep
    assert body is not None
    names = list(body.over)
    spec = StepSpec(
        step.name, "sweep",
        {**attractor_columns(plan), "chunk": Column("i8"), "cell": Column("i8"), "direction": Column("i4"), "share": Column("f8")},
        attractor_arrays(plan),
        {"parameters": list(plan.model.parameters), "states": list(plan.model.states), "segments": list(plan.model.segments), "free": names,
         "section": (body.section or Section.model_validate({"phase": 0.0})).model_dump(exclude_none=True), "model": plan.model.name,
         "units": units_of(plan),
         "settings": settings_text(plan, step)})  # fmt: skip
    chunks = chunks_of(plan, step)
    first, kept, kept_rows, points = 0, 0, dict.fromkeys(spec.orbits, 0), {}
    if recorded is not None and len(recorded):
        # The last chunk in the file may lack some of its rows: it is done again.
        points = dict(recorded.points)
        first = int(points["chunk"][-1])
        kept = int(np.sum(points["chunk"] < first))
        kept_rows = {name: int(recorded.orbits[f"{name}_end"][kept - 1]) if kept else 0 for name in spec.orbits}
    counts = Counter(_kind(not points["kind"][i], int(points["period"][i])) for i in range(kept))
    n_cells, done = sum(len(c.cells) for _, c in chunks), sum(len(c.cells) for _, c in chunks[:first])
    with StepWriter(context.path, spec, kept=kept, kept_rows=kept_rows) as writer:
        for number, found in enumerate(in_order(context.workers, sweep_chunk, [c for _, c in chunks[first:]]), first):
            direction, chunk = chunks[number]
            for f in found:
                row, arrays = attractor_row(f.attractor, f.cell.p, f.exponent)
                writer.append({**row, "chunk": number, "cell": f.cell.index, "direction": direction, "share": f.share}, arrays)
                counts[_kind(bool(f.attractor.failed), f.attractor.period)] += 1
            done += len(chunk.cells)
            context.reporter.advance(done, n_cells, "parameter points")
        text = f"{n_cells} parameter points; attractors: " + ", ".join(f"{n} {what}" for what, n in sorted(counts.items()))
        writer.terminate(text)
    context.reporter.done(text)


def _kind(failed: bool, period: int) -> str:
    return "failed" if failed else "periodic" if period else "without period"


def chunks_of(plan: Plan, step: Step) -> list[tuple[int, Chunk]]:
    """Return the work of a sweep: direction (+1 up, -1 down, 0 not carried) and chunk, in an order that only the file decides."""
    body = step.sweep
    assert body is not None
    p = plan.step_parameters(step)
    names = list(body.over)
    grids = [grid_values(plan, step, name) for name in names]
    task = task_of(plan, step, body, body.initial[0])

    def cell(index: int, values: tuple[float, ...]) -> Cell:
        here = p.copy()
        for name, value in zip(names, values, strict=True):
            here[plan.numeric.parameter_index(name)] = value
        here = plan.numeric.with_fixed(here)
        return Cell(index, here, clock_of(plan, body, here), starts(plan, body, here))

    # The first parameter runs fastest, so that one line of cells is one motion carried along.
    lines = [[cell(j * len(grids[0]) + i, (x, *rest)) for i, x in enumerate(grids[0])]
             for j, rest in enumerate(itertools.product(*grids[1:]))]  # fmt: skip
    if body.carry == "none":
        cells = [c for line in lines for c in line]
        size = max(1, CHUNK // len(cells[0].starts))
        return [(0, Chunk(task, tuple(cells[i : i + size]), False, body.lyapunov)) for i in range(0, len(cells), size)]
    ways = {"up": (1,), "down": (-1,), "both": (1, -1)}[body.carry]
    return [(way, Chunk(task, tuple(line[::way]), True, body.lyapunov)) for line in lines for way in ways]


def starts(plan: Plan, body: Sweep, p: Array) -> tuple[Start, ...]:
    """Return where motions start at parameters ``p``: the states that are given, then those at random, the same at every point."""
    given = [start_of(plan, initial, p) for initial in body.initial]
    if body.random is None:
        return tuple(given)
    rng = np.random.default_rng(body.random.seed)
    base = given[0]
    scattered = []
    for _ in range(body.random.number):
        states = base.states.copy()
        for name, (low, high) in body.random.box.items():
            states[plan.model.states.index(name)] = rng.uniform(plan.number(low, p), plan.number(high, p))
        scattered.append(Start(states, base.mode, base.constant))
    return (*given, *scattered) if "initial" in body.model_fields_set else tuple(scattered)
