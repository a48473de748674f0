"""What a ``precision`` step compares of orbits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from pddecont.codegen import NumericModel
from pddecont.collocation import MeshRule
from pddecont.delay import Direct
from pddecont.errors import ConvergenceError
from pddecont.model import add_chain_states
from pddecont.orbit import Monitor, Orbit, adapt_mesh, guess_chain_states, parse_monitor, solve_orbit
from pddecont.runfile import Delay, PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.execution.precision_case import PLAIN, Case, Finding
from pddecont.steps.execution.recorded_orbits import find_orbit
from pddecont.steps.precision import OrbitComparison, OrbitSetting
from pddecont.tables import REFERENCE

ROUGH = MeshRule(3, intervals=12)
# The two finest meshes; each is tried until rounding allows a tolerance.
FINEST = ((12, (1e-12, 1e-11, 1e-10)), (10, (1e-11, 1e-10, 1e-9)))
DIRECT = Delay.model_validate({"method": "direct"})


def list_orbit_cases(
    context: Context, step: PlannedStep[Any], comparison: OrbitComparison
) -> tuple[list[Case], Case, Case]:
    """Return the cases of a step that compares orbits, the reference and what checks it."""
    plan = context.plan
    assert step.source is not None, "a precision step's schema has a source"
    orbit = solve_orbit(find_orbit(context, step, step.source), step.rule).at.orbit
    rough = adapt_mesh(Orbit(replace(orbit.problem, delay=Direct(False)), orbit.x), ROUGH)

    @cache
    def add_states(order: int, n: int) -> tuple[NumericModel, tuple[Monitor, ...]]:
        numeric = NumericModel(add_chain_states(plan.model, order, n))
        return numeric, tuple(parse_monitor(numeric, name, text) for name, text in comparison.texts.items())

    def make_case(setting: OrbitSetting, method: str = "") -> Case:
        rule = setting.rule

        def compute() -> Finding:
            if setting.explicit:
                numeric, monitors = add_states(setting.order, setting.n)
                guess = guess_chain_states(rough, numeric, setting.order, setting.n, rule)
                return _solve(guess, monitors, rule, orbit.numeric.n_states)
            problem = replace(rough.problem, delay=setting.delay.make_method())
            return _solve(
                adapt_mesh(Orbit(problem, rough.x), rule), comparison.quantities, rule, orbit.numeric.n_states
            )

        columns = {
            **PLAIN,
            "method": (method or setting.delay.method).encode(),
            "tracked": setting.delay.track_breaking_points is not False,
            "order": setting.order,
            "explicit": setting.explicit,
            "degree": rule.degree,
            "intervals": rule.intervals or 0,
            "tolerance": rule.tol or np.nan,
            "n": setting.n,
            "parameters": orbit.problem.parameters,
        }
        return Case(columns, compute)

    def make_finest(degree: int, tolerances: Sequence[float]) -> Case:
        cases = [make_case(OrbitSetting(DIRECT, False, MeshRule(degree, None, tol)), REFERENCE) for tol in tolerances]

        def compute() -> Finding:
            for case in cases[:-1]:
                try:
                    return case.compute()
                except ConvergenceError:
                    continue
            return cases[-1].compute()

        # Which tolerance is reached is known when it is computed.
        return Case({**cases[-1].columns, "tolerance": np.nan}, compute)

    return [make_case(s) for s in comparison.settings], make_finest(*FINEST[0]), make_finest(*FINEST[1])


def _solve(guess: Orbit, monitors: Sequence[Monitor], rule: MeshRule, n_states: int) -> Finding:
    solution = solve_orbit(guess, rule)
    orbit = solution.at.orbit
    values = orbit.values[:, :n_states]
    return Finding(
        np.array([monitor.evaluate(orbit) for monitor in monitors]),
        values[orbit.mesh.last_base] if orbit.signature.has_events else np.zeros((0, n_states)),
        orbit.mesh.base_times(orbit.theta),
        values,
        len(orbit.x),
        orbit.mesh.n_intervals,
        solution.n_iterations,
    )
