"""Units of what a step records."""

from __future__ import annotations

import re

from pddecont.runfile import Plan

_SAME = re.compile(r"\s*(?:(?:min|max|mean|amplitude)\(|at\(\s*\w+\s*,)\s*(\w+)\s*\)\s*")
_TIME = re.compile(r"\s*(?:time_in\(\s*\w+\s*\)|period)\s*")


def find_units(plan: Plan) -> dict[str, str]:
    """Return the units that the model gives, and those of monitors that follow from them.

    Such a monitor is a time, or a value of one state or definition.
    """
    units = dict(plan.model.units)
    for name, text in plan.shared["monitors"].items():
        same = _SAME.fullmatch(str(text))
        unit = units.get(same[1]) if same else units.get("t") if _TIME.fullmatch(str(text)) else None
        if unit:
            units.setdefault(name, unit)
    return units
