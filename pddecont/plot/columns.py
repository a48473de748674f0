"""One number of each point by name, and what is shown of a step when nobody says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError, suggest
from pddecont.plot.axis_labels import COLUMNS, format_name
from pddecont.plot.engineering import write_number
from pddecont.results import Step
from pddecont.tables import holds_equilibria


def read_column(step: Step, name: str) -> NDArray[Any]:
    """Return a parameter, a monitor, a state of equilibria or another number of each point, shape (n_points,)."""
    for group in _list_groups(step):
        if name in step.meta[group]:
            return step.points[group][:, step.meta[group].index(name)]
    if name in step.points and step.points[name].ndim == 1 and step.points[name].dtype.kind in "fi":
        return step.points[name]
    known = list_columns(step)
    raise ResultsError(f"step '{step.name}' has no column '{name}'{suggest(name, known)} (columns: {', '.join(known)})")


def list_columns(step: Step) -> list[str]:
    """Return the names that :func:`read_column` takes."""
    return [
        *(name for group in _list_groups(step) for name in step.meta[group]),
        *(n for n in COLUMNS if n in step.points),
    ]


def _list_groups(step: Step) -> tuple[str, ...]:
    """Return the lists of names in a step's meta data that are those of columns of its points."""
    return ("parameters", "monitors", *(("states",) if holds_equilibria(step) else ()))


def read_parameter(step: Step, name: str) -> NDArray[np.float64]:
    """Return a parameter of each point, shape (n_points,), or raise :class:`ResultsError` with those there are."""
    names = list(step.meta["parameters"])
    if name not in names:
        raise ResultsError(
            f"step '{step.name}' has no parameter '{name}'{suggest(name, names)} (parameters: {', '.join(names)})"
        )
    return np.asarray(step.points["parameters"][:, names.index(name)])


def find_state(step: Step, name: str) -> int:
    """Return a state's number, or raise :class:`ResultsError` with the states there are."""
    states = list(step.meta["states"])
    if name not in states:
        raise ResultsError(
            f"step '{step.name}' has no state '{name}'{suggest(name, states)} (states: {', '.join(states)})"
        )
    return states.index(name)


def list_free_parameters(step: Step) -> list[str]:
    """Return the names of the free parameters of a branch, a curve or a sweep; none for other steps."""
    return list(step.meta.get("free") or [])


def choose_monitor(step: Step) -> str:
    """Return what is shown over free parameters when nobody says: the first monitor with values, else the period."""
    known = [m for m in step.meta["monitors"] if np.any(np.isfinite(read_column(step, m)))]
    return known[0] if known else "period"


def choose_states(step: Step, x: str | None, y: str | None) -> tuple[str, str]:
    """Return the two states of a phase plot: those asked for, else the first two (of one state twice the same)."""
    states = list(step.meta["states"])
    return x or states[0], y or states[min(1, len(states) - 1)]


def choose_plane(steps: Sequence[Step], x: str | None, y: str | None) -> tuple[str, str]:
    """Return the two parameters of a plane: those asked for, else the free parameters of the first curve."""
    free = next((found for step in steps if len(found := list_free_parameters(step)) == 2), [])
    if not free and not (x and y):
        raise ResultsError("there is no curve in two parameters to say which plane is meant; give -x and -y")
    x = x or next(name for name in free if name != y)
    return x, y or next(name for name in free if name != x)


def keep_comparable(steps: Sequence[Step]) -> list[Step]:
    """Return the last of ``steps`` and those with its free parameters, in whatever order, and values of the others."""
    *before, last = steps
    free = set(list_free_parameters(last))
    others = [name for name in last.meta["parameters"] if name not in free]
    return [*(s for s in before if set(list_free_parameters(s)) == free and share_values(s, last, others)), last]


def describe_point(step: Step, row: int) -> str:
    """Return a point's label and its free parameters."""
    values = [
        f"{format_name(name)} = {write_number(read_column(step, name)[row])}" for name in list_free_parameters(step)
    ]
    return "  ".join([t for t in (step.labels[row],) if t] + values)


def describe_differences(names: Sequence[str], values: NDArray[np.float64]) -> list[str]:
    """Return for each row of parameters, ``values`` of shape (n, n_parameters), those that are not the same in all."""
    varying = np.ptp(values, axis=0) > 0
    shown = [format_name(name) for name, varies in zip(names, varying, strict=True) if varies]
    return [
        "  ".join(f"{name} = {write_number(value)}" for name, value in zip(shown, row, strict=True))
        for row in values[:, varying]
    ]


def share_values(step: Step, other: Step, names: Sequence[str]) -> bool:
    """Return whether parameters have one value on two steps."""

    def read_value(s: Step, name: str) -> float:
        return float(s.points["parameters"][0, list(s.meta["parameters"]).index(name)])

    return all(
        name in step.meta["parameters"]
        and np.isclose(read_value(step, name), read_value(other, name), rtol=1e-9, atol=1e-12)
        for name in names
    )
