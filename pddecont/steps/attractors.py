"""Attractors in a results file: one row each, shared by sweep and basin steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results.attractors import motion_class
from pddecont.results.layout import Column
from pddecont.results.reader import Step as RecordedStep
from pddecont.simulate.attractors import Attractor
from pddecont.simulate.lyapunov import Exponent
from pddecont.steps.plan import Plan

NOTE_BYTES = 200
KIND = "A"


def attractor_columns(plan: Plan) -> dict[str, Column]:
    """Return the columns that describe an attractor.

    ``turn`` is the time of one period, ``n_segments`` counts each segment in it (without period: among the returns).
    """
    return {"kind": Column("S4"), "parameters": Column("f8", (len(plan.model.parameters),)), "period": Column("i4"), "turn": Column("f8"),
            "n_segments": Column("i8", (len(plan.model.segments),)), "lyapunov": Column("f8"), "lyapunov_error": Column("f8"),
            "note": Column(f"S{NOTE_BYTES}")}  # fmt: skip


def attractor_arrays(plan: Plan) -> dict[str, Column]:
    """Return the arrays with many rows an attractor: its returns, and the integration's state at the last of them."""
    n = plan.numeric.n_states
    return {"returns": Column("f8", (n,)), "return_slopes": Column("f8", (n,)), "return_time": Column("f8"), "memory": Column("f8")}


def attractor_row(attractor: Attractor, p: NDArray[np.float64], exponent: Exponent) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return an attractor as values of those columns and arrays; a motion that failed has no label."""
    points = {"kind": b"" if attractor.failed else KIND.encode(), "parameters": p, "period": attractor.period, "turn": attractor.turn,
              "n_segments": attractor.hits, "lyapunov": exponent.value, "lyapunov_error": exponent.uncertainty,
              "note": (attractor.failed or exponent.note).encode()[:NOTE_BYTES]}  # fmt: skip
    return points, {"returns": attractor.states, "return_slopes": attractor.slopes, "return_time": attractor.times,
                    "memory": attractor.memory}  # fmt: skip


def no_attractor(plan: Plan) -> dict[str, Any]:
    """Return a row of those columns that holds no attractor."""
    return {"kind": b"", "parameters": np.full(len(plan.model.parameters), np.nan), "period": -1, "turn": np.nan,
            "n_segments": np.zeros(len(plan.model.segments), int), "lyapunov": np.nan, "lyapunov_error": np.nan, "note": b""}  # fmt: skip


def recorded_attractor(step: RecordedStep, row: int) -> Attractor:
    """Return the attractor of a row."""
    points: Mapping[str, Any] = {name: column[row] for name, column in step.points.items()}
    arrays = step.orbit(row)
    failed = "" if points["kind"] else points["note"].decode(errors="replace")
    return Attractor(int(points["period"]), float(points["turn"]), arrays["returns"], arrays["return_slopes"], arrays["return_time"],
                     points["n_segments"], arrays["memory"], points["parameters"], failed)  # fmt: skip


def describe(attractor: Attractor, segments: list[str]) -> str:
    """Return an attractor in a few words: its period in returns and its segments."""
    if attractor.failed:
        return attractor.failed
    return motion_class(attractor.period, attractor.hits, segments)
