"""One row of a branch of equilibria: what is recorded of one, and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.delay import DelayMethod
from pddecont.equilibrium import ConstantMotion, Equilibrium, Roots, find_passed_side
from pddecont.errors import ResultsError
from pddecont.orbit import Monitor, make_resting_orbit
from pddecont.reasons import NEUTRAL, Reason, make_reason
from pddecont.results import Step
from pddecont.runfile import Plan, PlannedStep
from pddecont.steps.execution.units import find_units

Array = NDArray[np.float64]
# From here on delayed rates have coefficients that are said to be near one.
NEAR_ONE = 0.9


def make_equilibrium_meta(plan: Plan, step: PlannedStep[Any], kinds: dict[str, str]) -> dict[str, Any]:
    """Return what a step that records equilibria says of itself; ``kinds`` are its special points by label."""
    return {
        "monitors": list(plan.monitors),
        "kinds": kinds,
        "units": find_units(plan),
        "modes": list(plan.model.modes),
        "asked": ["stable"],
        "delay_method": repr(step.delay),
    }


def has_same_delays(recorded: Step, step: PlannedStep[Any]) -> bool:
    """Return whether delays were discretised as this step does, so that characteristic roots are the same."""
    return bool(recorded.meta.get("delay_method") == repr(step.delay))


def equilibrium_to_row(
    at: Equilibrium,
    roots: Roots,
    monitors: Sequence[Monitor],
    *,
    unknowns: Array,
    kind: str = "",
    arclength: float = 0.0,
    step: float = 0.0,
    tangent: Array | None = None,
    n_iterations: int = 0,
    error: float = np.nan,
    frequency: float = np.nan,
    coefficient: float = np.nan,
    n_unexplained: int = 0,
    side: Array | None = None,
    on_surface: str = "",
    others: Roots | None = None,
) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the row of points and the rows of arrays that record an equilibrium.

    ``on_surface`` is the event on whose surface a boundary equilibrium lies; ``others`` are the ``roots`` without those
    that it has on the imaginary axis by its nature (None: it has none).
    """
    admissible = find_passed_side(at, on_surface) is None
    deciding = roots if others is None else others
    motion, period = at.motion, 2.0 * np.pi / frequency if frequency > 0.0 else 1.0
    resting = make_resting_orbit(motion.numeric, motion.mode, at.states, at.parameters, motion.method, period)
    points: dict[str, Any] = {
        "kind": kind.encode(),
        "arclength": arclength,
        "parameters": at.motion.numeric.with_fixed(at.parameters),
        "states": at.states,
        "stable": _find_stable(deciding, admissible),
        "admissible": admissible,
        "counted": roots.counted,
        "n_unstable": deciding.n_unstable if deciding.counted else -1,
        "frequency": frequency,
        "coefficient": coefficient,
        "error_estimate": error,
        "monitors": np.array([monitor.evaluate(resting) for monitor in monitors]),
        "n_iterations": n_iterations,
        "step": step,
        "n_unknowns": len(unknowns),
        "unexplained": n_unexplained,
        "side": np.full(2, np.nan) if side is None else side,
    }
    rows: dict[str, Array] = {
        "unknowns": unknowns,
        "tangent": np.zeros(0) if tangent is None else tangent,
        "roots": np.stack([roots.values.real, roots.values.imag], axis=1),
        "residual": roots.residuals,
        "signature": np.frombuffer(at.motion.mode.encode(), dtype=np.uint8),
    }
    return points, rows


def _find_stable(roots: Roots, admissible: bool) -> int:
    """Return 1 for a stable equilibrium, 0 for one that is none or is virtual, -1 where the roots do not tell."""
    if not roots.counted:
        return -1
    stable = roots.stable if admissible else False
    return -1 if stable is None else int(stable)


def add_doubts(reason: Reason, at: Equilibrium, roots: Roots) -> Reason:
    """Return what is said of an equilibrium with what makes its characteristic roots doubtful."""
    negative = at.motion.find_negative_lag(at.states, at.parameters)
    if negative is not None and not reason:
        return make_reason("reads_future", delay=negative[0], lag=negative[1])
    if not roots.neutral_radius >= NEAR_ONE:
        return reason
    return Reason(reason.code or NEUTRAL, {**reason.values, NEUTRAL: roots.neutral_radius})


def equilibrium_from_row(plan: Plan, delay: DelayMethod, recorded: Step, row: int) -> Equilibrium:
    """Return a recorded equilibrium.

    Raises
    ------
    ResultsError
        If it is none of this model.
    """
    names, states = list(recorded.meta["parameters"]), list(recorded.meta["states"])
    mode = recorded.orbit(row)["signature"].tobytes().decode()
    missing = [name for name in plan.model.parameters if name not in names]
    if missing or states != list(plan.model.states) or mode not in plan.model.modes:
        raise ResultsError(
            f"step '{recorded.name}' comes from another model: it has parameters {', '.join(names)}, states "
            f"{', '.join(states)} and mode '{mode}'"
        )
    at = dict(zip(names, recorded.points["parameters"][row], strict=True))
    p = np.array([at[name] for name in plan.model.parameters])
    motion = ConstantMotion(plan.numeric, mode, delay)
    return Equilibrium(motion, np.array(recorded.points["states"][row]), p)
