"""Tables of steps that hold equilibria: points of branches, and characteristic roots."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.reasons import NEUTRAL
from pddecont.results import Step
from pddecont.tables.orbits import check_index
from pddecont.tables.words import describe_neutral, describe_reason

Row = dict[str, Any]


def holds_equilibria(step: Step) -> bool:
    """Return whether the points of a step are equilibria."""
    return "roots" in step.format.orbits


def list_equilibria(step: Step) -> list[Row]:
    """Return one row an equilibrium, in order along the branch."""
    return [_make_row(step, int(i)) for i in step.order]


def list_special_equilibria(step: Step) -> list[Row]:
    """Return the rows of :func:`list_equilibria` that have a label."""
    return [row for row in list_equilibria(step) if row["label"]]


def _make_row(step: Step, i: int) -> Row:
    p, meta = step.points, step.meta
    row: Row = {"index": i, "label": step.labels[i], "kind": step.kind_of(i), "mode": read_mode(step, i)}
    row |= {name: float(v) for name, v in zip(meta["parameters"], p["parameters"][i], strict=True)}
    row |= {name: float(v) for name, v in zip(meta["states"], p["states"][i], strict=True)}
    row |= {name: _truth(p[name][i]) for name in ("stable", "admissible")}
    row |= {
        "n_unstable": None if p["n_unstable"][i] < 0 else int(p["n_unstable"][i]),
        "counted": _truth(p["counted"][i]),
    }
    row |= {name: float(v) for name, v in zip(meta["monitors"], p["monitors"][i], strict=True)}
    row |= {name: float(p[name][i]) for name in ("frequency", "coefficient", "error_estimate")}
    return {**row, "note": describe_reason(step.reason(i))}


def list_roots(step: Step, row: int | None = None) -> list[Row]:
    """Return one row a characteristic root, by falling real part: of all points in branch order, or of one."""
    if row is not None:
        check_index(step, row)
    free = [(name, list(step.meta["parameters"]).index(name)) for name in step.meta.get("free") or []]
    rows = []
    for i in step.order if row is None else [row]:
        values = {name: float(step.points["parameters"][i, k]) for name, k in free}
        residuals = step.orbit(int(i))["residual"]
        for number, (root, residual) in enumerate(zip(read_roots(step, int(i)).tolist(), residuals, strict=True), 1):
            rows.append(
                {
                    "index": int(i),
                    "label": step.labels[i],
                    **values,
                    "number": number,
                    "re": root.real,
                    "im": root.imag,
                    "residual": float(residual),
                }
            )
    return rows


def read_roots(step: Step, i: int) -> NDArray[np.complex128]:
    """Return the characteristic roots of point ``i``, by falling real part."""
    pairs = step.orbit(i)["roots"]
    return np.asarray(pairs[:, 0] + 1j * pairs[:, 1])


def read_mode(step: Step, i: int) -> str:
    """Return the mode in which an equilibrium stays."""
    return str(step.orbit(i)["signature"].tobytes().decode())


def list_doubts(step: Step) -> list[str]:
    """Return what makes characteristic roots doubtful, in words: each once, with the number of points."""
    reasons = [step.reason(i) for i in range(len(step))]
    radii = [float(r.values[NEUTRAL]) for r in reasons if NEUTRAL in r.values]
    future = [r for r in reasons if r.code == "reads_future"]
    found = [(len(radii), describe_neutral(max(radii)))] if radii else []
    found += [(len(future), describe_reason(future[0]))] if future else []
    return [text if len(step) == 1 else f"at {number} of the points {text}" for number, text in found]


def _truth(value: np.int8) -> bool | None:
    return None if value < 0 else bool(value)
