"""Doing a ``simulate`` step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pddecont.reasons import make_reason
from pddecont.results import SIMULATE, Step
from pddecont.runfile import Plan, PlannedStep
from pddecont.simulate import Method, Trajectory, find_longest_lag, simulate
from pddecont.steps.context import Context
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.signals import evaluate_signals
from pddecont.steps.execution.units import find_units
from pddecont.steps.simulate import SimulateSettings


def find_trajectory(context: Context, step: PlannedStep[SimulateSettings]) -> Trajectory:
    """Return the trajectory of a simulate step; it is kept in memory for the steps that start from it."""
    if step.name not in context.trajectories:
        t_end = step.settings.t_end
        context.trajectories[step.name] = compute_trajectory(
            context.plan, step, step.settings.method, lambda t: context.reporter.progress(f"t = {t:.6g}", t / t_end)
        )
    return context.trajectories[step.name]


def compute_trajectory(
    plan: Plan, step: PlannedStep[SimulateSettings], method: Method, on_progress: Callable[[float], None] | None = None
) -> Trajectory:
    """Return the trajectory of a simulate step by ``method``; ``on_progress`` is called with times reached."""
    settings = step.settings
    # Signals read delayed values of what is recorded.
    longest = max(find_longest_lag(plan.numeric, p) for _, p in settings.stages)
    return simulate(
        plan.numeric,
        settings.parameters,
        step.delay,
        settings.t_end,
        method,
        initial=settings.start.states.tolist(),
        mode=settings.start.mode,
        constant=settings.start.constant,
        history=settings.history,
        schedule=settings.schedule,
        # How far back delays that vary reach is not known beforehand.
        keep_from=-np.inf if plan.model.varying else settings.record_from - longest,
        on_progress=on_progress,
    )


def run_simulate(context: Context, step: PlannedStep[SimulateSettings], recorded: Step | None) -> None:
    """Integrate and record the trajectory with its events."""
    plan, settings = context.plan, step.settings
    trajectory = find_trajectory(context, step)
    modes, segments = list(plan.model.modes), list(plan.model.segments)
    meta: dict[str, Any] = {
        "modes": modes,
        "segments": segments,
        "units": find_units(plan),
        "changes": [t for t, _ in settings.schedule],
        "signals": list(settings.signals),
    }
    since = settings.record_from
    if settings.record_every is None:
        times, states, in_mode = trajectory.sample()
        late = times >= since
        times, states, in_mode = times[late], states[late], [m for m, kept in zip(in_mode, late, strict=True) if kept]
    else:
        times, states, in_mode = trajectory.sample_every(settings.record_every, since)
    signals = list(settings.signals.values())
    values = evaluate_signals(plan.numeric, signals, trajectory, times, states, settings.stages, settings.past)
    events = trajectory.events
    late = events.t >= since
    points = {
        "parameters": settings.parameters,
        "t_end": trajectory.t_end,
        "n_steps": trajectory.n_steps,
        "n_events": int(late.sum()),
    }
    rows = {
        "time": times,
        "states": states,
        "mode": np.array([modes.index(m) for m in in_mode]),
        "signals": values,
        "event_time": events.t[late],
        "event_segment": np.array([segments.index(s) for s in events.segment], dtype=int)[late],
        "before": events.before[late],
        "after": events.after[late],
    }
    with context.open_step(step, SIMULATE, meta, capacity=1) as writer:
        writer.append(points, rows)
        writer.terminate(make_reason("reached", since=since))
    report_done(context, step)
