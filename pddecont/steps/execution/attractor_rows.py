"""Attractors in a results file: one row each, shared by sweep and basin steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.reasons import NO_REASON, Reason
from pddecont.results import Step
from pddecont.runfile import Plan
from pddecont.simulate import Attractor, LyapunovExponent, failure_from_reason, failure_to_reason
from pddecont.tables import NO_EXPONENT

# Labels of attractors: A1, A2, ...
KIND = "A"


def attractor_to_row(
    attractor: Attractor, p: NDArray[np.float64], exponent: LyapunovExponent, segments: Sequence[str]
) -> tuple[dict[str, Any], dict[str, NDArray[Any]], Reason]:
    """Return what a results file keeps of an attractor; a motion that failed has no label, but a reason.

    ``segments`` are those that the file counts.
    """
    points = {
        "kind": b"" if attractor.failure else KIND.encode(),
        "parameters": p,
        "period": attractor.period,
        "turn": attractor.turn,
        "n_segments": np.array([attractor.segment_counts.get(name, 0) for name in segments], dtype=int),
        "lyapunov": exponent.value,
        "lyapunov_error": exponent.uncertainty,
    }
    rows = {
        "returns": attractor.states,
        "return_slopes": attractor.slopes,
        "return_time": attractor.times,
        "memory": attractor.packed_state,
    }
    return points, rows, _find_reason(attractor, exponent)


def _find_reason(attractor: Attractor, exponent: LyapunovExponent) -> Reason:
    if attractor.failure is not None:
        return failure_to_reason(attractor.failure)
    if exponent.failure is None:
        return NO_REASON
    cause = failure_to_reason(exponent.failure)
    return Reason(NO_EXPONENT, {"cause": cause.code, **cause.values})


def list_known_segments(plan: Plan, recorded: Step | None) -> list[str]:
    """Return the segments that a file counts from the start: those of the step so far, and those of the model."""
    before = [] if recorded is None else recorded.meta["segments"]
    return list(dict.fromkeys([*before, *plan.model.segments]))


def make_empty_row(plan: Plan, segments: Sequence[str]) -> dict[str, Any]:
    """Return a row that holds no attractor."""
    return {
        "kind": b"",
        "parameters": np.full(len(plan.model.parameters), np.nan),
        "period": -1,
        "turn": np.nan,
        "n_segments": np.zeros(len(segments), int),
        "lyapunov": np.nan,
        "lyapunov_error": np.nan,
    }


def attractor_from_row(step: Step, row: int) -> Attractor:
    """Return the attractor of a row.

    Raises
    ------
    ResultsError
        If the row holds none, nor says why.
    """
    points, arrays, reason = step.points, step.orbit(row), step.reason(row)
    try:
        failure = None if step.kind_of(row) else failure_from_reason(reason)
    except ValueError as exc:
        raise ResultsError(f"step '{step.name}': row {row} holds no attractor; the file is damaged") from exc
    return Attractor(
        int(points["period"][row]),
        float(points["turn"][row]),
        arrays["returns"],
        arrays["return_slopes"],
        arrays["return_time"],
        {name: int(n) for name, n in zip(step.meta["segments"], points["n_segments"][row], strict=True) if n},
        arrays["memory"],
        points["parameters"][row],
        failure,
    )
