"""The ``simulate`` step: a trajectory from the model's initial state or history."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.results.layout import Column, StepSpec
from pddecont.results.writer import StepWriter
from pddecont.simulate.integrate import simulate
from pddecont.simulate.simulator import Method
from pddecont.simulate.trajectory import Trajectory
from pddecont.steps.context import Context, settings_text
from pddecont.steps.integration import history_of, method_of, start_of
from pddecont.steps.plan import Plan, as_number
from pddecont.steps.schema import Step
from pddecont.steps.signals import signal_values
from pddecont.steps.units import units_of

Array = NDArray[np.float64]


def integrate(context: Context, step: Step) -> Trajectory:
    """Return the trajectory of a simulate step; it is kept in memory for the steps that start from it."""
    if step.name in context.trajectories:
        return context.trajectories[step.name][0]
    plan = context.plan
    assert step.simulate is not None
    p = plan.step_parameters(step)
    t_end, changes = plan.number(step.simulate.t_end, p), schedule(plan, step, p)
    trajectory = trajectory_of(plan, step, method_of(plan, step, step.simulate),
                               lambda t: context.reporter.progress(f"t = {t:.6g}", t / t_end))  # fmt: skip
    context.trajectories[step.name] = (trajectory, changes[-1][1] if changes else p)
    return trajectory


def trajectory_of(plan: Plan, step: Step, method: Method, heard: Callable[[float], None] | None = None) -> Trajectory:
    """Return the trajectory of a simulate step by ``method``; ``heard`` hears of times reached."""
    body = step.simulate
    assert body is not None
    p = plan.step_parameters(step)
    start, changes = start_of(plan, body.initial, p), schedule(plan, step, p)
    # Signals read delayed values of what is recorded.
    longest = max(float(np.max(plan.numeric.delays.value(q), initial=0.0)) for q in (p, *(q for _, q in changes)))
    return simulate(
        plan.numeric, p, plan.delay_method(step), plan.number(body.t_end, p), method, initial=list(start.states), mode=start.mode,
        constant=start.constant, history=history_of(plan, body.initial), schedule=changes,
        keep_from=plan.number(body.record.from_, p) - longest, heard=heard)  # fmt: skip


def past_of(plan: Plan, step: Step, p: Array) -> Sequence[sympy.Expr]:
    """Return the history of a step's motion as expressions in t."""
    assert step.simulate is not None
    initial = step.simulate.initial
    if initial.history == "constant":
        return [sympy.Float(x) for x in start_of(plan, initial, p).states]
    return history_of(plan, initial) or plan.model.history


def schedule(plan: Plan, step: Step, p: Array) -> list[tuple[float, Array]]:
    """Return the times at which parameters change, in order, and the parameters from then on."""
    assert step.simulate is not None
    changes = []
    for time, values in sorted(((plan.number(as_number(text), p), v) for text, v in step.simulate.at.items()), key=lambda pair: pair[0]):
        p = p.copy()
        for name, text in values.items():
            p[plan.numeric.parameter_index(name)] = plan.number(text, p)
        changes.append((time, plan.numeric.with_fixed(p)))
    return changes


def run_simulate(context: Context, step: Step) -> None:
    """Integrate and record the trajectory with its events."""
    plan = context.plan
    trajectory = integrate(context, step)
    assert step.simulate is not None
    p = plan.step_parameters(step)
    record, changes = step.simulate.record, schedule(plan, step, p)
    signals = record.signals
    model, n = plan.model, plan.numeric.n_states
    modes, segments = list(model.modes), list(model.segments)
    spec = StepSpec(
        step.name, "simulate",
        {"parameters": Column("f8", (len(p),)), "t_end": Column("f8"), "n_steps": Column("i8"), "n_events": Column("i8")},
        {"time": Column("f8"), "states": Column("f8", (n,)), "mode": Column("i4"), "event_time": Column("f8"),
         "event_segment": Column("i4"), "before": Column("f8", (n,)), "after": Column("f8", (n,)),
         "signals": Column("f8", (len(signals),))},
        {"parameters": list(model.parameters), "states": list(model.states), "modes": modes, "segments": segments,
         "model": model.name, "units": units_of(plan), "settings": settings_text(plan, step),
         "changes": [t for t, _ in changes], "signals": list(signals)})  # fmt: skip
    since = plan.number(record.from_, p)
    if record.every is None:
        times, states, in_mode = trajectory.sampled()
        late = times >= since
        times, states, in_mode = times[late], states[late], [m for m, kept in zip(in_mode, late, strict=True) if kept]
    else:
        times, states, in_mode = trajectory.every(plan.number(record.every, p), since)
    values = signal_values(plan, signals, trajectory, times, states, [(-np.inf, p), *changes],
                           past_of(plan, step, p))  # fmt: skip
    events = trajectory.events
    late = events.t >= since
    with StepWriter(context.path, spec, capacity=1) as writer:
        writer.append(
            {"parameters": p, "t_end": trajectory.t_end, "n_steps": trajectory.n_steps, "n_events": int(late.sum())},
            {"time": times, "states": states, "mode": np.array([modes.index(m) for m in in_mode]), "signals": values,
             "event_time": events.t[late], "event_segment": np.array([segments.index(s) for s in events.segment], dtype=int)[late],
             "before": events.before[late], "after": events.after[late]})  # fmt: skip
        when = f" since t = {since:.10g}" if since else ""
        text = f"reached t = {trajectory.t_end:.10g} in {trajectory.n_steps} steps with {int(late.sum())} events{when}"
        writer.terminate(text)
    context.reporter.done(text)
