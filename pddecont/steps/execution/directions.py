"""The directions of a branch: how one ended, and which one a recorded branch was on."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from pddecont.continuation import Termination
from pddecont.reasons import Reason, Scalar
from pddecont.results import Step


def make_branch_ending(end: Termination, way: int, next_signature: str = "") -> Reason:
    """Return how a direction ended, as it is recorded."""
    values: dict[str, Scalar] = {"direction": way, "unexplained": end.n_unexplained}
    if end.detail:
        values |= {"detail": end.detail.code, **end.detail.values}
    return Reason(str(end.end), {**values, **({"next_signature": next_signature} if next_signature else {})})


def find_unfinished(recorded: Step, ways: Sequence[int], ended: Collection[int]) -> tuple[int, int | None, int]:
    """Return the direction that was under way, its last ordinary row (None: there is none), and rows to keep."""
    arclength = recorded.points["arclength"]
    for way in ways:
        if way in ended:
            continue
        rows = np.flatnonzero(arclength * way > 0).tolist()
        while rows and recorded.kind_of(rows[-1]):
            rows.pop()
        if rows:
            return way, rows[-1], rows[-1] + 1
        return way, None, 1 + max(np.flatnonzero(arclength * way <= 0).tolist(), default=0)
    return 0, None, len(recorded)
