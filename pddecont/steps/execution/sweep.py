"""Doing a ``sweep`` step."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.reasons import make_reason
from pddecont.results import SWEEP, Step
from pddecont.runfile import Plan, PlannedStep
from pddecont.simulate import InitialState, MotionTask, ParameterPoint, SweepChunk, map_in_order, sweep_chunk
from pddecont.steps.context import Context
from pddecont.steps.execution.attractor_rows import attractor_to_row, list_known_segments
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.units import find_units
from pddecont.steps.sweep import SweepSettings

Array = NDArray[np.float64]
# Motions in a chunk of work that is not carried along.
CHUNK = 8


def run_sweep(context: Context, step: PlannedStep[SweepSettings], recorded: Step | None) -> None:
    """Find the attractors at every parameter point; those of an unfinished step are kept."""
    plan, settings = context.plan, step.settings
    meta: dict[str, Any] = {
        "segments": list_known_segments(plan, recorded),
        "free": list(settings.grids),
        "section": dict(settings.settling.shown_section),
        "units": find_units(plan),
    }
    chunks = list_chunks(plan, settings)
    first, kept = 0, 0
    if recorded is not None and len(recorded):
        # The last chunk in the file may lack some of its rows: it is done again.
        first = int(recorded.points["chunk"][-1])
        kept = int(np.sum(recorded.points["chunk"] < first))
    n_points = sum(len(chunk.points) for _, chunk in chunks)
    done = sum(len(chunk.points) for _, chunk in chunks[:first])
    settling = settings.settling
    task = MotionTask(plan.numeric, step.delay, settling.method, settling.section, settings.history)
    work = partial(sweep_chunk, task)
    with context.open_step(step, SWEEP, meta, recorded=recorded, kept=kept) as writer:
        results = map_in_order(context.workers, work, [chunk for _, chunk in chunks[first:]])
        for number, attractors in enumerate(results, first):
            direction, chunk = chunks[number]
            for found in attractors:
                segments = writer.list_more("segments", found.attractor.segment_counts)
                points, rows, reason = attractor_to_row(found.attractor, found.point.p, found.exponent, segments)
                place = {"chunk": number, "cell": found.point.index, "direction": direction, "share": found.share}
                writer.append({**points, **place}, rows, reason)
            done += len(chunk.points)
            context.reporter.advance(done, n_points, "parameter points")
            if done < n_points:
                context.budget.check()
        writer.terminate(make_reason("swept", n_cells=n_points))
    report_done(context, step)


def list_chunks(plan: Plan, settings: SweepSettings) -> list[tuple[int, SweepChunk]]:
    """Return the work of a sweep in an order that only the file decides.

    Each part is a direction (+1 up, -1 down, 0 not carried) and a chunk.
    """
    names, grids, exponents = list(settings.grids), list(settings.grids.values()), settings.settling.lyapunov
    n_points = math.prod(map(len, grids))
    sequence = draw_sequence(settings, n_points)

    def make_point(index: int, values: Sequence[float]) -> ParameterPoint:
        p = settings.parameters.copy()
        for name, value in zip(names, values, strict=True):
            p[plan.numeric.parameter_index(name)] = value
        p = plan.numeric.with_fixed(p)
        shares = None if sequence is None else sequence[index, len(names) :]
        starts = make_starts(plan, settings, p, shares)
        return ParameterPoint(index, p, settings.settling.make_return_settings(plan.numeric, p), starts)

    if sequence is not None:
        low, high = np.transpose([(grid[0], grid[-1]) for grid in grids])
        places = low + (high - low) * sequence[:, : len(names)]
        points = [make_point(i, place.tolist()) for i, place in enumerate(places)]
        return share_out(points, exponents)
    # The first parameter runs fastest, so that one line of points is one motion carried along.
    lines = [
        [make_point(j * len(grids[0]) + i, (x, *rest)) for i, x in enumerate(grids[0])]
        for j, rest in enumerate(itertools.product(*grids[1:]))
    ]
    if settings.ways:
        return [(way, SweepChunk(tuple(line[::way]), True, exponents)) for line in lines for way in settings.ways]
    return share_out([point for line in lines for point in line], exponents)


def share_out(points: Sequence[ParameterPoint], exponents: bool) -> list[tuple[int, SweepChunk]]:
    """Return points that are not carried along in chunks."""
    size = max(1, CHUNK // len(points[0].starts))
    return [(0, SweepChunk(tuple(points[i : i + size]), False, exponents)) for i in range(0, len(points), size)]


def draw_sequence(settings: SweepSettings, n_points: int) -> Array | None:
    """Return points of a Sobol sequence, shape (n_points, n_parameters + number x n_states that vary); None for a grid.

    References
    ----------
    Owen, J. Complexity 14 (1998) 466, for how the sequence is scrambled.
    """
    scatter = settings.scatter
    if scatter is None or not scatter.spread:
        return None
    # Loading it takes a third of a second, which other sweeps need not wait for.
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(settings.grids) + scatter.number * len(scatter.box), seed=scatter.seed)
    # The sequence is even over powers of two.
    return np.asarray(sequence.random_base2(math.ceil(math.log2(n_points)))[:n_points])


def make_starts(plan: Plan, settings: SweepSettings, p: Array, shares: Array | None = None) -> tuple[InitialState, ...]:
    """Return where motions start at parameters ``p``: the states given, then those at random.

    They are the same at every point, unless ``shares`` says where in the box they lie, from 0 to 1.
    """
    values = plan.name_values(p)
    starts = [start.evaluate(values) for start in settings.starts]
    scatter = settings.scatter
    if scatter is None:
        return tuple(starts)
    if shares is None:
        shares = np.random.default_rng(scatter.seed).uniform(size=scatter.number * len(scatter.box))
    base = settings.scattered_from.evaluate(values)
    for shares_of_start in shares.reshape(scatter.number, len(scatter.box)):
        states = base.states.copy()
        for (place, (low, high)), share in zip(scatter.box.items(), shares_of_start, strict=True):
            lowest = low.evaluate(values)
            states[place] = lowest + (high.evaluate(values) - lowest) * share
        starts.append(InitialState(states, base.mode, base.constant))
    return tuple(starts)
