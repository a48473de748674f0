"""What a step leaves that others can start from."""

from __future__ import annotations

from enum import StrEnum


class Holding(StrEnum):
    """What a step leaves that others can start from."""

    NOTHING = "nothing"
    TRAJECTORY = "trajectory"
    ORBIT = "orbit"
    EQUILIBRIA = "equilibria"
    BRANCH = "branch"
    ATTRACTORS = "attractors"
