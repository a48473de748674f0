"""Doing a ``basin`` step."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.reasons import make_reason
from pddecont.results import BASIN, RowWriter, Step
from pddecont.runfile import PlannedStep
from pddecont.simulate import (
    Attractor,
    BasinRow,
    LyapunovExponent,
    MotionTask,
    classify_row,
    find_lyapunov_exponent,
    find_or_add,
    map_in_order,
    survey_attractors,
)
from pddecont.steps.basin import BasinSettings
from pddecont.steps.context import Context
from pddecont.steps.execution.attractor_rows import (
    attractor_from_row,
    attractor_to_row,
    list_known_segments,
    make_empty_row,
)
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.units import find_units

Array = NDArray[np.float64]
# Initial states along each side of the grid that are followed first, to learn which attractors there are.
FIRST_LOOK = 7


def run_basin(context: Context, step: PlannedStep[BasinSettings], recorded: Step | None) -> None:
    """Label every cell.

    Rows are attractors as they are found (with a label) and lines of the grid (with their cells' labels).
    """
    plan, settings = context.plan, step.settings
    xs, ys, p, settling = settings.x, settings.y, settings.parameters, settings.settling
    meta: dict[str, Any] = {
        "segments": list_known_segments(plan, recorded),
        "over": list(settings.names),
        "x": xs.tolist(),
        "y": ys.tolist(),
        "units": find_units(plan),
    }
    task = MotionTask(plan.numeric, step.delay, settling.method, settling.section, settings.history)
    returns = settling.make_return_settings(plan.numeric, p)
    context.reporter.progress("looking for attractors")
    few_x, few_y = (v[np.unique(np.linspace(0, len(v) - 1, FIRST_LOOK).round().astype(int))] for v in (xs, ys))
    coarse = place_states(settings, np.stack(np.meshgrid(few_x, few_y), axis=-1).reshape(-1, 2))
    first = tuple(survey_attractors(task, p, returns, coarse, settings.start))
    known, done, kept = list(first), 0, 0
    if recorded is not None and len(recorded) > len(first):
        done, kept = int(recorded.points["line"].max()) + 1, len(recorded)
        known = [attractor_from_row(recorded, int(i)) for i in np.flatnonzero(recorded.points["line"] < 0)]
    add = partial(_write_attractor, task=task, p=p, duration=returns.transient, with_exponents=settling.lyapunov)
    with context.open_step(step, BASIN, meta, recorded=recorded, kept=kept) as writer:
        for attractor in first if not kept else ():
            add(writer, attractor)
        lines = [
            BasinRow(
                p, returns, place_states(settings, np.stack([xs, np.full(len(xs), y)], axis=-1)), settings.start, first
            )
            for y in ys[done:]
        ]
        for number, line in enumerate(map_in_order(context.workers, partial(classify_row, task), lines), done):
            labels = line.labels.copy()
            for cell, attractor in line.strays.items():
                before = len(known)
                labels[cell] = find_or_add(
                    attractor, known, settling.method.atol, at_section=not returns.forcing_period
                )
                if len(known) > before:
                    add(writer, attractor)
            writer.append(
                {**make_empty_row(plan, writer.list_more("segments", ())), "line": number},
                {"label": labels, "settling": line.times},
            )
            context.reporter.advance(number + 1, len(ys), "lines of the grid")
        writer.terminate(make_reason("mapped"))
    report_done(context, step)


def place_states(settings: BasinSettings, points: Array) -> Array:
    """Return the states of points (n_points, 2) of the rectangle, shape (n_points, n_states)."""
    states = np.repeat(settings.start.states[None], len(points), axis=0)
    states[:, list(settings.places)] = points
    return states


def _write_attractor(
    writer: RowWriter, attractor: Attractor, *, task: MotionTask, p: Array, duration: float, with_exponents: bool
) -> None:
    exponent = LyapunovExponent()
    if with_exponents and not attractor.failure:
        simulator = task.make_simulator()
        exponent = find_lyapunov_exponent(simulator, simulator.values(p), attractor, duration)
    segments = writer.list_more("segments", attractor.segment_counts)
    points, rows, reason = attractor_to_row(attractor, p, exponent, segments)
    writer.append({**points, "line": -1}, rows, reason)
