"""A branch as parts that are drawn alike: of one family of motions, stable or not, admissible or not."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from itertools import groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.special_points import read_kind
from pddecont.results import Step
from pddecont.tables import find_signature, holds_equilibria


class LineStyle(StrEnum):
    """How matplotlib draws a part's line, in the order in which it is chosen between the two sides of a border."""

    SOLID = "-"
    DASHED = "--"
    DOTTED = ":"


# Ordinary points, end points and zeros of user functions lie inside a part; where any other special point lies a
# property of the orbits changes.
INNER_KINDS = ("", "EP", "UF")


@dataclass(frozen=True)
class Family:
    """Orbits with one signature, up to where it begins, and one number of forcing periods; or equilibria of one mode.

    Of equilibria (``rests``) the mode stands where the signature does.
    """

    signature: str
    n_periods: int = 1
    rests: bool = False


@dataclass(frozen=True)
class BranchPart:
    """Consecutive points of a branch, ``rows`` of shape (n,), whose connecting lines are drawn alike.

    ``start`` counts the points that lie before them along the branch.
    """

    rows: NDArray[np.intp]
    style: LineStyle
    family: Family
    start: int


def split_branch(step: Step) -> list[BranchPart]:
    """Return the parts of a branch in order; neighbours share the point where they meet.

    A special point lies on a border and says nothing of the sides: a line that ends there is as its other end says.
    Nothing joins points with different numbers of periods: what is recorded of a whole orbit jumps there. Points that
    lie on no branch are a part each.
    """
    order = step.order
    if len(order) == 1 or not step.format.has_branch:
        return [
            BranchPart(row, _choose_style(step, row), find_family(step, int(row[0])), k)
            for k, row in enumerate(order[:, None])
        ]
    lines = [_describe_line(step, a, b) for a, b in pairwise(order)]
    parts, start = [], 0
    for line, same in groupby(lines):
        n = len(list(same))
        if line is not None:
            parts.append(BranchPart(order[start : start + n + 1], *line, start))
        start += n
    return parts


def find_family(step: Step, row: int) -> Family:
    """Return the family that a recorded orbit, or equilibrium, belongs to."""
    if holds_equilibria(step):
        return Family(find_signature(step, row), rests=True)
    n_periods = int(step.points["n_periods"][row]) if "n_periods" in step.points else 1
    return Family(rotate_signature(find_signature(step, row)), n_periods)


@lru_cache(maxsize=1024)
def rotate_signature(text: str) -> str:
    """Return the rotation of a signature that comes first in alphabetical order: the same for all its rotations."""
    names = text.split()
    return " ".join(min((names[i:] + names[:i] for i in range(len(names))), default=[]))


def _describe_line(step: Step, a: int, b: int) -> tuple[LineStyle, Family] | None:
    """Return style and family of the line between two neighbours; None where nothing joins them."""
    if find_family(step, a).n_periods != find_family(step, b).n_periods:
        return None
    inner = np.array([i for i in (a, b) if read_kind(step, i) in INNER_KINDS], dtype=int)
    if len(inner):
        return _choose_style(step, inner), find_family(step, int(inner[0]))
    ends = np.array([a, b])
    styles = {_choose_style(step, ends[:1]), _choose_style(step, ends[1:])}
    return next(style for style in LineStyle if style in styles), find_family(step, a)


def _choose_style(step: Step, rows: NDArray[np.intp]) -> LineStyle:
    for name, style in (("admissible", LineStyle.DOTTED), ("stable", LineStyle.DASHED)):
        if name in step.points and np.any(step.points[name][rows] == 0):
            return style
    return LineStyle.SOLID
