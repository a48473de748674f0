"""What a ``precision`` step compares of simulations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.execution.precision_case import PLAIN, Case, Finding
from pddecont.steps.execution.signals import evaluate_signals
from pddecont.steps.execution.simulate import compute_trajectory
from pddecont.steps.precision import IntegrationComparison, IntegratorSetting
from pddecont.steps.simulate import SimulateSettings
from pddecont.tables import REFERENCE

FINEST_RUNS = (IntegratorSetting("explicit", 3e-14), IntegratorSetting("explicit", 3e-13))


def list_integration_cases(
    context: Context, step: PlannedStep[Any], comparison: IntegrationComparison
) -> tuple[list[Case], Case, Case]:
    """Return the cases of a step that compares simulations, the reference and what checks it."""
    plan = context.plan
    assert step.source is not None, "a precision step's schema has a source"
    source: PlannedStep[SimulateSettings] = plan.find_step(step.source.step)
    own, t_end = source.settings.method, np.array([source.settings.t_end])
    quantities = list(comparison.quantities.values())

    def make_case(setting: IntegratorSetting, method: str = "") -> Case:
        def compute() -> Finding:
            # atol stays in its proportion to rtol.
            atol = own.atol / own.rtol * setting.tolerance
            stiff = setting.integrator == "stiff"
            trajectory = compute_trajectory(plan, source, replace(own, rtol=setting.tolerance, atol=atol, stiff=stiff))
            end = trajectory(t_end)
            stages, past = source.settings.stages, source.settings.past
            values = evaluate_signals(plan.numeric, quantities, trajectory, t_end, end, stages, past)[0]
            return Finding(values, np.zeros((0, len(plan.model.states))), t_end, end, n_steps=trajectory.n_steps)

        columns = {
            **PLAIN,
            "method": (method or setting.integrator).encode(),
            "tolerance": setting.tolerance,
            "parameters": source.settings.parameters,
        }
        return Case(columns, compute)

    finest, check = (make_case(setting, REFERENCE) for setting in FINEST_RUNS)
    return [make_case(setting) for setting in comparison.settings], finest, check
