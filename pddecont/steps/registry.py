"""The registry of kinds of steps: the program's own, and those that others make known."""

from __future__ import annotations

from typing import Any

from pddecont.results import forget_format, register_format
from pddecont.steps.basin import BASIN_STEP
from pddecont.steps.continuation import CONTINUE_STEP
from pddecont.steps.equilibrium import EQUILIBRIUM_STEP
from pddecont.steps.explore import EXPLORE_STEP
from pddecont.steps.kind import StepKind
from pddecont.steps.orbit import ORBIT_STEP
from pddecont.steps.precision import PRECISION_STEP
from pddecont.steps.simulate import SIMULATE_STEP
from pddecont.steps.sweep import SWEEP_STEP

BUILTIN: tuple[StepKind[Any, Any], ...] = (
    SIMULATE_STEP,
    SWEEP_STEP,
    BASIN_STEP,
    EQUILIBRIUM_STEP,
    ORBIT_STEP,
    CONTINUE_STEP,
    PRECISION_STEP,
    EXPLORE_STEP,
)
_REGISTERED: dict[str, StepKind[Any, Any]] = {}


def list_step_kinds() -> dict[str, StepKind[Any, Any]]:
    """Return all kinds by name: the program's own, then those that were registered."""
    return {kind.name: kind for kind in BUILTIN} | _REGISTERED


def has_registered_step_kinds() -> bool:
    """Return whether others made kinds known in this process."""
    return bool(_REGISTERED)


def register_step_kind(kind: StepKind[Any, Any]) -> None:
    """Make a kind of step known, and what it keeps in results files.

    Raises
    ------
    ValueError
        If another kind has its name.
    """
    if kind.name in list_step_kinds():
        raise ValueError(f"there is a kind of step '{kind.name}' already")
    register_format(kind.format)
    _REGISTERED[kind.name] = kind


def forget_step_kind(name: str) -> None:
    """Forget a kind that :func:`register_step_kind` made known."""
    forget_format(_REGISTERED.pop(name).format.kind)
