"""One number of each point, by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError, suggest
from pddecont.plot.style import label
from pddecont.results.reader import Step

PLAIN = ("period", "error_estimate", "clearance", "arclength", "n_unstable", "trivial_error")


def column(step: Step, name: str) -> NDArray[Any]:
    """Return a parameter, a monitor or another number of each point, by name, shape (n_points,)."""
    for group in ("parameters", "monitors"):
        if name in step.meta[group]:
            return step.points[group][:, step.meta[group].index(name)]
    if name in step.points and step.points[name].ndim == 1 and step.points[name].dtype.kind in "fi":
        return step.points[name]
    known = columns(step)
    raise ResultsError(f"step '{step.name}' has no column '{name}'{suggest(name, known)} (columns: {', '.join(known)})")


def columns(step: Step) -> list[str]:
    """Return the names that :func:`column` offers."""
    return [*step.meta["parameters"], *step.meta["monitors"], *(n for n in PLAIN if n in step.points)]


def free_of(step: Step) -> list[str]:
    """Return the names of the free parameters of a branch or curve; none for other steps."""
    return list(step.meta.get("free") or [])


def default_height(step: Step) -> str:
    """Return what is shown over the free parameters when nobody says: the first monitor with values, else the period."""
    others = [m for m in step.meta["monitors"] if np.any(np.isfinite(column(step, m)))]
    return others[0] if others else "period"


def default_columns(step: Step) -> tuple[str, str]:
    """Return what a diagram shows when nobody says: the free parameter and :func:`default_height`."""
    return (free_of(step) or step.meta["parameters"][:1] or ["period"])[0], default_height(step)


def title(step: Step, row: int) -> str:
    """Return a point's label and its free parameters."""
    values = [f"{label(name)} = {column(step, name)[row]:.6g}" for name in free_of(step)]
    return "  ".join([t for t in (step.labels[row],) if t] + values)


def agree(step: Step, other: Step, names: Sequence[str]) -> bool:
    """Whether parameters have one value on two steps."""

    def value(s: Step, name: str) -> float:
        return float(s.points["parameters"][0, list(s.meta["parameters"]).index(name)])

    return all(name in step.meta["parameters"] and np.isclose(value(step, name), value(other, name), rtol=1e-9, atol=1e-12)
               for name in names)  # fmt: skip
