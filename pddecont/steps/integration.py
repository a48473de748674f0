"""What a step says of how motions are computed and where they start, resolved to numbers."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.errors import RunError
from pddecont.model.expression import ExpressionError, parse
from pddecont.simulate.attractors import Clock
from pddecont.simulate.simulator import Method
from pddecont.simulate.simulator import Section as Returns
from pddecont.simulate.task import Start, Task
from pddecont.steps.context import settings_text
from pddecont.steps.plan import Plan
from pddecont.steps.schema import Initial, Integration, Settling, Step

Array = NDArray[np.float64]


def method_of(plan: Plan, step: Step, body: Integration) -> Method:
    """Return how a step integrates."""
    longest = np.inf if body.max_step is None else plan.number(body.max_step, plan.step_parameters(step))
    return Method(body.rtol, body.atol, body.method == "stiff", dict(body.stick), longest)


def start_of(plan: Plan, initial: Initial, p: Array) -> Start:
    """Return where a motion starts; states that are not given are those of the model's history at t = 0."""
    names = dict(zip(plan.model.parameters, p, strict=True))
    given = initial.states
    try:
        states = [plan.number(given[s], p) if s in given else plan.model.evaluate(e, names, 0.0)
                  for s, e in zip(plan.model.states, history_of(plan, initial) or plan.model.history, strict=True)]  # fmt: skip
    except ExpressionError as exc:
        raise RunError.at(plan.source, 0, 0, f"the history at t = 0 {exc}") from exc
    return Start(np.array(states), initial.mode or plan.model.initial_mode, initial.history == "constant")


def history_of(plan: Plan, initial: Initial) -> tuple[sympy.Expr, ...] | None:
    """Return the expressions in t that a step gives as history, the model's where it gives none of a state; None if it gives none."""
    if not isinstance(initial.history, Mapping):
        return None
    scope = plan.model.history_scope()
    return tuple(parse(initial.history[s], scope) if s in initial.history else e
                 for s, e in zip(plan.model.states, plan.model.history, strict=True))  # fmt: skip


def returns_of(plan: Plan, body: Settling) -> Returns:
    """Return the section at which returns are counted; none where they are counted by the forcing."""
    section = body.section
    if section is None or section.phase is not None:
        return Returns()
    if section.event is not None:
        return Returns(event=section.event)
    assert section.zero is not None
    return Returns(expr=parse(section.zero, plan.model.scope("a section")), direction=section.direction)


def clock_of(plan: Plan, body: Settling, p: Array) -> Clock:
    """Return when returns come at parameters ``p``."""
    stroboscopic = body.section is None or body.section.phase is not None
    period = float(plan.numeric.period.value(p)[0]) if stroboscopic and plan.model.forced else 0.0
    phase = body.section.phase if body.section is not None and body.section.phase is not None else 0.0
    return Clock(period, phase, plan.number(body.transient, p), body.max_period, body.returns)


def task_of(plan: Plan, step: Step, body: Settling, initial: Initial) -> Task:
    """Return what workers need to compute motions of a step."""
    token = hashlib.sha256((plan.model_text + settings_text(plan, step)).encode()).hexdigest()
    return Task(plan.model, plan.delay_method(step), method_of(plan, step, body), returns_of(plan, body), history_of(plan, initial), token)


def grid_values(plan: Plan, step: Step, name: str) -> Array:
    """Return the values that a sweep or basin step gives to ``name``."""
    body = step.sweep or step.basin
    assert body is not None
    low, high, n = body.over[name]
    p = plan.step_parameters(step)
    return np.linspace(plan.number(low, p), plan.number(high, p), int(n))


