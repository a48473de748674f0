"""Orbits of results files that steps start from."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.orbit import Orbit, make_mesh, mesh_is_valid, orbit_from_rows, transfer_to
from pddecont.results import Step
from pddecont.runfile import PlannedStep, Source
from pddecont.steps.context import Context


def find_point(context: Context, source: Source) -> tuple[Step, int]:
    """Return the recorded step that a step starts from, and the row of its point.

    Raises
    ------
    ResultsError
        If it holds no orbits, or none of this label or index.
    """
    results, recorded = context.read_source(source)
    if "mesh" not in recorded.format.orbits:
        raise ResultsError(f"step '{source.step}' of {results.path} is a {recorded.kind} step and holds no orbits")
    row = recorded.row(source.point) if source.point else source.index or 0
    if row >= len(recorded):
        raise ResultsError(f"step '{source.step}' of {results.path} has {len(recorded)} points, no index {row}")
    return recorded, row


def find_orbit(context: Context, step: PlannedStep[Any], source: Source) -> Orbit:
    """Return the recorded orbit that a step starts from, at the step's own delay method, mesh and parameters.

    Where those are the recorded orbit's own it solves its problem already; otherwise it is a guess.

    Raises
    ------
    ResultsError
        If it is not an orbit of this model.
    """
    plan = context.plan
    recorded, row = find_point(context, source)
    names = recorded.meta["parameters"]
    unknown = [name for name in plan.model.parameters if name not in names]
    if unknown or list(recorded.meta["states"]) != list(plan.model.states):
        raise ResultsError(
            f"step '{source.step}' comes from another model: it has parameters {', '.join(names)} and states "
            f"{', '.join(recorded.meta['states'])}"
        )
    at_row = dict(zip(names, recorded.points["parameters"][row], strict=True))
    p = np.array([at_row[name] for name in plan.model.parameters])
    try:
        old = orbit_from_rows(
            plan.numeric,
            step.delay,
            p,
            (),
            recorded.orbit(row),
            int(recorded.points["n_periods"][row]),
            float(recorded.points["phase"][row]),
        )
    except (ValueError, IndexError, ZeroDivisionError, OverflowError) as exc:
        raise ResultsError(
            f"point {row} of step '{source.step}' is not an orbit of this model: {exc}; the file is damaged or was "
            "made by a changed model"
        ) from exc
    problem = replace(old.problem, parameters=plan.set_parameters(step, p))
    orbit = Orbit(problem, old.x)
    if recorded.meta["mesh_settings"] == step.mesh_settings and mesh_is_valid(orbit):
        return orbit
    return transfer_to(old, problem, make_mesh(problem, orbit.theta, step.rule, orbit=orbit))
