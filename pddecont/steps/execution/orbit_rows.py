"""One row of a branch: what is recorded of an orbit."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import list_kinds, measure_grazing_gap
from pddecont.orbit import NOT_DONE, Monitor, Orbit, Verifier, find_violation, orbit_to_rows
from pddecont.results import Step
from pddecont.runfile import Plan, PlannedStep
from pddecont.stability import MultiplierCache, Multipliers
from pddecont.steps.execution.units import find_units
from pddecont.steps.orbit import MultiplierSettings

Array = NDArray[np.float64]
# Rounding of a plane's coefficients, relative to them.
ROUNDING = 1e-14


def make_orbit_meta(plan: Plan, step: PlannedStep[Any], recorded: Step | None = None) -> dict[str, Any]:
    """Return what a step that records orbits says of itself; ``recorded`` is what the file holds of it."""
    before = [] if recorded is None else recorded.meta.get("events", [])
    return {
        "monitors": list(plan.monitors),
        "events": list(dict.fromkeys([*before, *plan.model.events])),
        "delayed": [s.name for s in plan.model.read_symbols],
        "kinds": {kind.label: kind.name for kind in list_kinds()},
        "mesh_settings": step.mesh_settings,
        "units": find_units(plan),
        # What was to be known of each orbit, though it may not have been found.
        "asked": [
            *(["verified"] if step.settings.verifies else []),
            *(["stable"] if step.settings.multipliers.wanted else []),
        ],
        **describe_choice(plan, step),
    }


def describe_choice(plan: Plan, step: PlannedStep[Any]) -> dict[str, str]:
    """Return, for a run with an accuracy, the delay and mesh of a step as text.

    Steps that start from it use them again.
    """
    if plan.accuracy is None or step.fields["mesh"] is None:
        return {}
    used = {"delay": step.fields["delay"] or plan.shared["delay"], "mesh": step.fields["mesh"]}
    given = {key: {k: v for k, v in value.items() if v is not None} for key, value in used.items()}
    return {"choice": json.dumps(given)}


def make_multiplier_cache(settings: MultiplierSettings) -> MultiplierCache | None:
    """Return what finds multipliers as a step asks for them, or None if it does not."""
    return MultiplierCache(settings.number) if settings.wanted else None


def make_referee(plan: Plan, step: PlannedStep[Any]) -> Verifier | None:
    """Return what simulates a step's orbits, or None if they are not to be verified."""
    if not step.settings.verifies:
        return None
    # What simulates is imported by runs that simulate, and by no others.
    from pddecont.orbit import Referee

    return Referee(plan.numeric, step.delay)


def orbit_to_row(
    orbit: Orbit,
    monitors: Sequence[Monitor],
    events: Sequence[str],
    *,
    error: float,
    kind: str = "",
    arclength: float = 0.0,
    n_iterations: int = 0,
    step: float = 0.0,
    tangent: Array | None = None,
    multipliers: Multipliers | None = None,
    n_shown: int | None = None,
    side: Array | None = None,
    referee: Verifier | None = None,
) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the row of points and the rows of arrays that record an orbit.

    ``events`` are those whose surfaces the step keeps, ``n_shown`` is the number of multipliers that were asked for,
    ``error`` is the orbit's estimated error.
    An orbit that is no motion of the model is not stable.
    """
    unknown = multipliers is None or not multipliers.says_stability
    verification = NOT_DONE if referee is None else referee.verify(orbit)
    is_motion = not find_violation(orbit, referee)
    points: Mapping[str, Any] = {
        "kind": kind.encode(),
        "arclength": arclength,
        "parameters": orbit.numeric.with_fixed(orbit.parameters),
        "period": orbit.period,
        "stable": _find_stable(multipliers, is_motion),
        "n_unstable": -1 if multipliers is None or unknown else multipliers.n_unstable,
        "trivial_error": np.nan if multipliers is None else multipliers.trivial_error,
        "side": np.full(2, np.nan) if side is None else side,
        "admissible": is_motion,
        "verified": verification.verified,
        "deviation": verification.deviation,
        "error_estimate": error,
        "monitors": np.array([monitor.evaluate(orbit) for monitor in monitors]),
        "clearance": measure_grazing_gap(orbit),
        "n_iterations": n_iterations,
        "step": step,
        "n_periods": orbit.problem.n_periods,
        "phase": orbit.problem.phase,
        "n_unknowns": len(orbit.x),
        "surfaces": find_surfaces(orbit, events),
    }
    shown = None if multipliers is None else multipliers.leading(n_shown)
    values, residuals = (np.zeros(0, dtype=complex), np.zeros(0)) if shown is None else (shown.values, shown.residuals)
    rows = {
        "multipliers": np.stack([values.real, values.imag], axis=1),
        "residual": residuals,
        "delayed": orbit.delayed_values,
    }
    return dict(points), {**orbit_to_rows(orbit, tangent), **rows}


def _find_stable(multipliers: Multipliers | None, is_motion: bool) -> int:
    """Return 1 for a stable orbit, 0 for one that is none or no motion, -1 where the multipliers do not tell."""
    if multipliers is None or not multipliers.says_stability:
        return -1
    stable = multipliers.stable if is_motion else False
    return -1 if stable is None else int(stable)


def find_surfaces(orbit: Orbit, events: Sequence[str]) -> Array:
    """Return the surface a . z = b of each of some events as the row (a, b), shape (n_events, n_states + 1).

    It is NaN where the surface is not a plane.
    """
    model, n = orbit.numeric.model, orbit.numeric.n_states
    result = np.full((len(events), n + 1), np.nan)
    p = orbit.parameters
    for i, event in enumerate(map(model.events.__getitem__, events)):
        if event.function is None or not event.function.free_symbols <= {
            *model.state_symbols,
            *model.parameter_symbols,
        }:
            continue
        function = orbit.numeric.event(event.name)
        d = function.derivatives(
            np.zeros(2), np.outer(np.ones(n), [0.0, 1.0]), np.zeros((len(model.read_symbols), 2)), p
        )
        if not (np.all(np.isfinite(d.dx)) and np.all(np.isfinite(d.value))):
            continue
        if np.ptp(d.dx, axis=1).max(initial=0.0) <= ROUNDING * (1 + np.max(np.abs(d.dx), initial=0.0)):
            result[i] = 0.0
            result[i, function.structure().dx[1]], result[i, n] = d.dx[:, 0], -d.value[0, 0]
    return result
