"""What may be said of a run beside its steps, and of an exploration: for those who check types.

A key that is not known is a RunError that names the ones there are, as in a file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict


class RunKeys(TypedDict, total=False):
    """Keys of a run file, in place of the run's own; what may be under each is in the reference of run files."""

    delay: Mapping[str, Any]
    mesh: Mapping[str, Any]
    monitors: Mapping[str, str | float]
    effects: Mapping[str, Any]
    accuracy: float


class ExploreKeys(TypedDict, total=False):
    """Keys of a step ``explore`` beside ``over``; what may be under each is in the reference of run files."""

    rtol: float
    atol: float
    method: Literal["explicit", "stiff"]
    max_step: str | float
    stick: Mapping[str, str]
    box: Mapping[str, Sequence[str | float]]
    transient: str | float
    section: Mapping[str, Any]
    starts: int
    check: int
    seed: int
    max_period: int
    depth: int
    step: Mapping[str, Any]
    max_points: int
