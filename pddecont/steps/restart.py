"""From an attractor of a sweep or basin step back to a motion: its recorded state is gone on from."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.results.summary import effects_off
from pddecont.simulate.integrate import follow
from pddecont.simulate.kernel.tables import T
from pddecont.simulate.snapshot import moved, restart_time, unpack
from pddecont.simulate.trajectory import Trajectory
from pddecont.steps.attractors import recorded_attractor
from pddecont.steps.context import Context, attractor_step
from pddecont.steps.integration import task_of
from pddecont.steps.schema import Source, Step

Array = NDArray[np.float64]
# Turns of an attractor's period that are integrated, and least in all, for its period to be seen in them.
TURNS, LEAST = 4, 8


def attractor_trajectory(context: Context, step: Step, source: Source) -> tuple[Trajectory, Array]:
    """Return some periods of a recorded attractor, computed as it was, and its parameters.

    Raises
    ------
    ResultsError
        If the row holds no attractor with a period, or the step was another run's and cannot be gone on from here.
    """
    plan = context.plan
    recorded = attractor_step(context, source)
    assert recorded is not None
    if source.point is None and source.index is None:
        labels = [x for x in recorded.labels if x]
        raise ResultsError(f"step '{source.step}' holds {len(labels)} attractors; say which: "
                           f"{{step: {source.step}, point: {labels[0] if labels else 'A1'}}}")  # fmt: skip
    row = recorded.row(source.point) if source.point else source.index or 0
    if row >= len(recorded):
        raise ResultsError(f"step '{source.step}' has {len(recorded)} rows, no index {row}")
    attractor = recorded_attractor(recorded, row)
    if attractor.failed or attractor.period <= 0:
        raise ResultsError(f"{source.point or source.index} of step '{source.step}' has no period that was found"
                           f"{': ' + attractor.failed if attractor.failed else ''}; a periodic orbit cannot start from it")  # fmt: skip
    if recorded.meta["model"] != plan.model.name or recorded.meta["parameters"] != list(plan.model.parameters):
        raise ResultsError(f"step '{source.step}' comes from another model, '{recorded.meta['model']}'")
    try:
        off, origin = effects_off(recorded), Step.model_validate(json.loads(recorded.meta["settings"])["step"])
    except (ValueError, KeyError, TypeError, AttributeError) as exc:
        raise ResultsError(f"the settings of step '{source.step}' cannot be read; the file is damaged") from exc
    off_here = list(plan.model.left_out.effects)
    if off != off_here:
        here, there = (f"without {', '.join(names)}" if names else "with all effects" for names in (off_here, off))
        raise ResultsError(f"step '{source.step}' was computed {there}, this run is {here}; an orbit starts from attractors of the same "
                           "effects")  # fmt: skip
    body = origin.sweep or origin.basin
    assert body is not None
    initial = body.initial[0] if isinstance(body.initial, list) else body.initial
    simulator = task_of(plan, origin, body, initial).simulator()
    values = simulator.values(attractor.p)
    try:
        memory = unpack(simulator.system, values, attractor.memory)
    except ValueError as exc:
        raise ResultsError(f"step '{source.step}': {exc}; the file is damaged or was made by a changed model") from exc
    memory = moved(memory, restart_time(plan.numeric, attractor.p, attractor.p, float(memory.clock[T])))
    longest = float(max(plan.numeric.delays.value(attractor.p), default=0.0))
    duration = max(TURNS, LEAST / attractor.period) * attractor.turn + longest
    return follow(simulator, attractor.p, memory, float(memory.clock[T]) + duration), attractor.p
