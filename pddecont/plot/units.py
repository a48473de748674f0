"""Names on axes, with the units that the model gives."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from pddecont.plot.style import label
from pddecont.results.reader import Step

_POWER = re.compile(r"(?:\^|\*\*)\(?(-?\d+)\)?")


def axis_label(steps: Step | Sequence[Step], name: str) -> str:
    """Return a name as mathematics and its unit in parentheses, where one of the steps knows it."""
    several = [steps] if isinstance(steps, Step) else steps
    unit = next((found for step in several if (found := unit_of(step.meta.get("units", {}), name))), "")
    return f"{label(name)} ({written(unit)})" if unit else label(name)


def unit_of(units: Mapping[str, str], name: str) -> str:
    """Return the unit of a column, state or delayed value; empty if the model does not say."""
    if name == "period":
        return units.get("t", "")
    return units.get(name) or units.get(name.partition("(")[0], "")


def written(unit: str) -> str:
    """Return a unit with its powers raised: ``m/s^2`` or ``m/s**2``; anything else stays as it is."""
    return _POWER.sub(r"$^{\1}$", unit.replace("$", r"\$"))
