"""Tables of steps that hold orbits: points of branches, orbits, Floquet multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.results import Step
from pddecont.tables.words import describe_reason

Row = dict[str, Any]


def list_points(step: Step) -> list[Row]:
    """Return one row a point, in order along the branch."""
    rows = []
    p = step.points
    for i in step.order:
        row: Row = {"index": int(i), "label": step.labels[i], "kind": step.kind_of(int(i))}
        row |= {name: float(v) for name, v in zip(step.meta["parameters"], p["parameters"][i], strict=True)}
        row |= {"period": float(p["period"][i]), "stable": _truth(p["stable"][i])}
        row |= {"admissible": _truth(p["admissible"][i])}
        if "verified" in p:
            row |= {"verified": _truth(p["verified"][i]), "deviation": float(p["deviation"][i])}
        row |= {name: float(v) for name, v in zip(step.meta["monitors"], p["monitors"][i], strict=True)}
        row |= {"error_estimate": float(p["error_estimate"][i]), "n_unstable": _count(step, int(i))}
        row |= {"note": describe_reason(step.reason(int(i))), "n_unknowns": int(p["n_unknowns"][i])}
        rows.append(row)
    return rows


def list_special_points(step: Step) -> list[Row]:
    """Return the rows of :func:`list_points` that have a label."""
    return [row for row in list_points(step) if row["label"]]


def list_orbit(step: Step, i: int) -> list[Row]:
    """Return one row a time of the orbit of point ``i``."""
    check_index(step, i)
    orbit = step.orbit(i)
    names = step.meta["states"]
    return [
        {"t": float(t), "segment": int(s) + 1, **dict(zip(names, map(float, z), strict=True))}
        for t, s, z in zip(orbit["time"], orbit["segment"], orbit["states"], strict=True)
    ]


def list_multipliers(step: Step, row: int | None = None) -> list[Row]:
    """Return one row a Floquet multiplier, by falling modulus: of all points in order along the branch, or of one."""
    if row is not None:
        check_index(step, row)
    if not has_multipliers(step):
        raise ResultsError(f"step '{step.name}' has no multipliers; run it with 'stability: true'")
    free = [(name, list(step.meta["parameters"]).index(name)) for name in step.meta.get("free") or []]
    rows = []
    for i in step.order if row is None else [row]:
        values = {name: float(step.points["parameters"][i, k]) for name, k in free}
        found = zip(read_multipliers(step, int(i)), read_residuals(step, int(i)), strict=True)
        for number, (value, residual) in enumerate(found, 1):
            rows.append(
                {
                    "index": int(i),
                    "label": step.labels[i],
                    **values,
                    "number": number,
                    "multiplier": complex(value),
                    "modulus": float(abs(value)),
                    "residual": float(residual),
                }
            )
    return rows


def has_multipliers(step: Step) -> bool:
    """Return whether multipliers were computed for any point."""
    return len(step.orbits.get("multipliers", ())) > 0


def read_multipliers(step: Step, i: int) -> NDArray[np.complex128]:
    """Return the multipliers of point ``i``, by falling modulus; shape (0,) if they were not computed."""
    if "multipliers" not in step.orbits:
        return np.empty(0, dtype=complex)
    pairs = step.orbit(i)["multipliers"]
    return np.asarray(pairs[:, 0] + 1j * pairs[:, 1])


def read_residuals(step: Step, i: int) -> NDArray[np.float64]:
    """Return the residuals of the multipliers of point ``i``; NaN in files of versions that kept none."""
    n = len(read_multipliers(step, i))
    residuals = step.orbit(i)["residual"] if "residual" in step.orbits else np.zeros(0)
    return np.asarray(residuals) if len(residuals) == n else np.full(n, np.nan)


def find_signature(step: Step, row: int) -> str:
    """Return the names of the segments of a recorded orbit, separated by spaces; empty where none is recorded."""
    if "signature" not in step.orbits:
        return ""
    end = step.orbits["signature_end"]
    return str(step.orbits["signature"][end[row - 1] if row else 0 : end[row]].tobytes().decode())


def check_index(step: Step, i: int) -> None:
    """Raise ResultsError if a step has no point of an index."""
    if not 0 <= i < len(step):
        raise ResultsError(f"step '{step.name}' has {len(step)} points, no index {i}")


def _count(step: Step, i: int) -> int | None:
    value = int(step.points["n_unstable"][i]) if "n_unstable" in step.points else -1
    return None if value < 0 else value


def _truth(value: np.int8) -> bool | None:
    return None if value < 0 else bool(value)
