"""The ``simulate`` step: a trajectory from the model's initial state or history."""

from __future__ import annotations

import numpy as np

from pddecont.results.layout import Column, StepSpec
from pddecont.results.writer import StepWriter
from pddecont.simulate.integrate import Tolerances, simulate
from pddecont.simulate.trajectory import Trajectory
from pddecont.steps.context import Context, settings_text
from pddecont.steps.schema import Step


def integrate(context: Context, step: Step) -> Trajectory:
    """Return the trajectory of a simulate step; it is kept in memory for the steps that start from it."""
    if step.name in context.trajectories:
        return context.trajectories[step.name][0]
    body, plan = step.simulate, context.plan
    assert body is not None
    p = plan.step_parameters(step)
    t_end = plan.number(body.t_end, p)
    initial = None
    given = {k: v for k, v in body.initial.items() if k != "mode"}
    if given:
        defaults = [plan.model.evaluate(e.subs({"t": 0}), dict(zip(plan.model.parameters, p, strict=True))) for e in plan.model.history]
        initial = [plan.number(given[s], p) if s in given else d for s, d in zip(plan.model.states, defaults, strict=True)]
    mode = body.initial.get("mode")
    trajectory = simulate(plan.numeric, p, plan.delay_method(step), t_end, Tolerances(body.rtol, body.atol), initial,
                          None if mode is None else str(mode), lambda t: context.reporter.progress(f"t = {t:.6g}", t / t_end))  # fmt: skip
    context.trajectories[step.name] = (trajectory, p)
    return trajectory


def run_simulate(context: Context, step: Step) -> None:
    """Integrate and record the trajectory with its events."""
    plan = context.plan
    trajectory = integrate(context, step)
    p = context.trajectories[step.name][1]
    model, n = plan.model, plan.numeric.n_states
    modes, segments = list(model.modes), list(model.segments)
    spec = StepSpec(
        step.name, "simulate",
        {"parameters": Column("f8", (len(p),)), "t_end": Column("f8"), "n_steps": Column("i8"), "n_events": Column("i8")},
        {"time": Column("f8"), "states": Column("f8", (n,)), "mode": Column("i4"), "event_time": Column("f8"),
         "event_segment": Column("i4"), "before": Column("f8", (n,)), "after": Column("f8", (n,))},
        {"parameters": list(model.parameters), "states": list(model.states), "modes": modes, "segments": segments,
         "model": model.name, "settings": settings_text(plan, step)})  # fmt: skip
    times, states, in_mode = trajectory.sampled()
    events = trajectory.events
    with StepWriter(context.path, spec, capacity=1) as writer:
        writer.append(
            {"parameters": p, "t_end": trajectory.t_end, "n_steps": trajectory.n_steps, "n_events": len(events)},
            {"time": times, "states": states, "mode": np.array([modes.index(m) for m in in_mode]),
             "event_time": np.array([e.t for e in events]), "event_segment": np.array([segments.index(e.segment) for e in events]),
             "before": np.array([e.before for e in events]).reshape(-1, n),
             "after": np.array([e.after for e in events]).reshape(-1, n)})  # fmt: skip
        text = f"reached t = {trajectory.t_end:.10g} in {trajectory.n_steps} steps with {len(events)} events"
        writer.terminate(text)
    context.reporter.done(text)
