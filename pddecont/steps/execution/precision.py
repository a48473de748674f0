"""Doing a ``precision`` step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError
from pddecont.reasons import NO_REASON, Reason, make_reason
from pddecont.results import PRECISION, Step
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.execution.cost import Cost, measure_cost
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.integration_cases import list_integration_cases
from pddecont.steps.execution.orbit_cases import list_orbit_cases
from pddecont.steps.execution.precision_case import Case, Finding
from pddecont.steps.execution.units import find_units
from pddecont.steps.precision import IntegrationComparison, OrbitComparison

Array = NDArray[np.float64]
COSTS = ("wall", "wall_low", "wall_high", "cpu", "memory")
SIZES = ("n_unknowns", "n_intervals", "n_iterations", "n_steps")


@dataclass(frozen=True, eq=False)
class Reference:
    """Closed forms (NaN where none is given) and the finest solution, with another mesh's to check it."""

    closed: Array
    best: Finding
    other: Finding

    @property
    def values(self) -> Array:
        """The quantities."""
        return np.where(np.isnan(self.closed), self.best.values, self.closed)

    @property
    def scale(self) -> Array:
        """Sizes that errors are relative to."""
        return np.where(self.values == 0.0, 1.0, np.abs(self.values))

    @property
    def errors(self) -> Array:
        """How far the finest solution is from the closed form, or from the other mesh's, relative to the size."""
        against = np.where(np.isnan(self.closed), self.other.values, self.closed)
        return np.abs(self.best.values - against) / self.scale


def run_precision(
    context: Context, step: PlannedStep[OrbitComparison | IntegrationComparison], recorded: Step | None
) -> None:
    """Solve the reference, then one setting after another; each is a row of the results."""
    comparison = step.settings
    if isinstance(comparison, IntegrationComparison):
        cases, finest, check = list_integration_cases(context, step, comparison)
    else:
        cases, finest, check = list_orbit_cases(context, step, comparison)
    context.reporter.progress("the reference")
    best, cost = measure_cost(finest.compute, comparison.repeats)
    reference = Reference(np.array(comparison.reference), best, check.compute())
    names = zip(comparison.names, comparison.reference, strict=True)
    meta: dict[str, Any] = {
        "quantities": comparison.names,
        "closed": [name for name, value in names if not np.isnan(value)],
        "ends": best.ends.tolist(),
        "repeats": comparison.repeats,
        "units": find_units(context.plan),
    }
    kept = len(recorded) if recorded is not None else 0
    with context.open_step(step, PRECISION, meta, recorded=recorded, kept=kept) as writer:
        if kept == 0:
            writer.append(*make_row(finest, best, cost, reference))
        for i, case in enumerate(cases, 1):
            if i < kept:
                continue
            try:
                row = (*make_row(case, *measure_cost(case.compute, comparison.repeats), reference), NO_REASON)
            except ConvergenceError as exc:
                row = (*make_failed_row(case, reference), make_reason("message", text=str(exc)))
            writer.append(*row)
            context.reporter.advance(i, len(cases), "settings")
        writer.terminate(Reason("compared"))
    report_done(context, step)


def make_row(case: Case, found: Finding, cost: Cost, reference: Reference) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the row of what a setting found and cost."""
    best = reference.best
    errors = reference.errors if found is best else np.abs(found.values - reference.values) / reference.scale
    same = found.ends.shape == best.ends.shape and len(best.ends) > 0
    # eq. (4.1) of the paper
    distance = float(np.sum(np.linalg.norm(found.ends - best.ends, axis=1))) if same else np.nan
    points = {
        **case.columns,
        "values": found.values,
        "errors": errors,
        "error": float(np.max(errors)),
        "distance": distance,
        **{name: getattr(cost, name) for name in COSTS},
        **{name: getattr(found, name) for name in SIZES},
    }
    return points, {"time": found.time, "states": found.states}


def make_failed_row(case: Case, reference: Reference) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the row of a setting that found nothing."""
    nothing = np.full(len(reference.values), np.nan)
    points = {
        **case.columns,
        "values": nothing,
        "errors": nothing,
        **dict.fromkeys(("error", "distance", "wall", "wall_low", "wall_high", "cpu"), np.nan),
        **dict.fromkeys(("memory", *SIZES), 0),
    }
    return points, {"time": np.zeros(0), "states": np.zeros((0, reference.best.states.shape[1]))}
