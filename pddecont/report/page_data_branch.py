"""A branch as lines: which parts are stable, unstable or not admissible, and of which motions."""

from __future__ import annotations

from typing import Any

from pddecont.plot import LineStyle, split_branch
from pddecont.report.packed_arrays import ArrayPacker
from pddecont.results import Step
from pddecont.tables import shorten_signature

STYLES = tuple(LineStyle)


def describe_branch(packer: ArrayPacker, step: Step) -> dict[str, Any]:
    """Return the parts of a branch: ``parts`` holds first point, number of points, style and family of each.

    Styles count solid (stable, or not known), dashed (unstable) and dotted (not admissible) from 0. ``joined`` says
    whether points are neighbours on a branch, or lie by themselves.
    """
    parts = split_branch(step)
    families = list(dict.fromkeys(part.family for part in parts))
    numbers = [[part.start, len(part.rows), STYLES.index(part.style), families.index(part.family)] for part in parts]
    return {
        "joined": bool(step.format.has_branch),
        "parts": packer.add(numbers, "<u4"),
        "families": [[shorten_signature(family.signature), family.n_periods] for family in families],
        "curve": str(step.meta.get("curve") or ""),
    }
