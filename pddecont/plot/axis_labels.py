"""Names and units as they are written on axes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from pddecont.results import Step

GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda", "mu", "nu"),
    *("xi", "pi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega"),
)
# Columns of their own that axes may show beside parameters and monitors.
COLUMNS = (
    *("period", "error_estimate", "clearance", "arclength", "n_unstable", "trivial_error"),
    *("frequency", "coefficient"),
)
# A letter, Greek or not, and a number.
_NUMBERED = re.compile(r"([A-Za-z]|" + "|".join(GREEK) + r")(\d+)")
# A delayed value, as recorded orbits name it.
_DELAYED = re.compile(r"([A-Za-z]\w*)\(t - ([A-Za-z]\w*)\)", re.ASCII)
_POWER = re.compile(r"(?:\^|\*\*)\(?(-?\d+)\)?")


def format_axis_label(steps: Step | Sequence[Step], name: str) -> str:
    """Return a name as mathematics and its unit in parentheses, where one of the steps knows it."""
    several = [steps] if isinstance(steps, Step) else steps
    unit = next((found for step in several if (found := find_unit(step.meta.get("units", {}), name))), "")
    return f"{format_name(name)} ({format_unit(unit)})" if unit else format_name(name)


def format_name(name: str) -> str:
    """Return a name in italics, as in mathematics: ``tau_d`` with its Greek letter and index, words as they are.

    Columns that every file has (:data:`COLUMNS`) are no names but words.
    """
    if name in COLUMNS:
        return name.replace("_", " ")
    if delayed := _DELAYED.fullmatch(name):
        return "{}$(t - ${}$)$".format(*map(format_name, delayed.groups())).replace("$$", "")
    # In a file from somebody else a name may hold anything.
    name = name.replace("$", r"\$")
    if not name.isidentifier() or not name.isascii():
        return name
    first, _, rest = name.partition("_")
    if not rest and (numbered := _NUMBERED.fullmatch(first)):
        first, rest = numbered.groups()
    if "_" in rest or not (first in GREEK or len(first) == 1):
        words = name.strip("_").replace("_", r"\ ") or r"\_"
        return f"$\\mathit{{{words}}}$"
    body = f"\\{first}" if first in GREEK else first
    # An index of several letters is a word.
    index = rest if len(rest) < 2 or rest.isdigit() else f"\\mathrm{{{rest}}}"
    return f"${body}_{{{index}}}$" if rest else f"${body}$"


def find_unit(units: Mapping[str, str], name: str) -> str:
    """Return the unit of a column, state or delayed value; empty if the model does not say."""
    if name == "period":
        return units.get("t", "")
    return units.get(name) or units.get(name.partition("(")[0], "")


def format_unit(unit: str) -> str:
    """Return a unit with its powers raised: ``m/s^2`` or ``m/s**2``; anything else stays as it is."""
    return _POWER.sub(r"$^{\1}$", unit.replace("$", r"\$"))
