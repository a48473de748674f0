"""What each column of a table means, its unit, and how it is kept where values may be missing: for data frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pddecont.results import Step

# Types of pandas for columns in which a value may be unknown.
TRUTH, COUNT = "boolean", "Int64"


@dataclass(frozen=True)
class ColumnText:
    """What a column holds; ``type`` is given where a value may be unknown, ``unit`` where it follows from that of time.

    ``unit`` is a pattern for the unit of time, such as ``1/{}``.
    """

    text: str
    type: str | None = None
    unit: str = ""


_POINTS: Mapping[str, ColumnText] = {
    "index": ColumnText("number of the point, in the order in which points were computed"),
    "label": ColumnText("name of a special point; empty for others"),
    "kind": ColumnText("what a special point is, as its label begins"),
    "stable": ColumnText("whether the orbit or the equilibrium is stable", TRUTH),
    "admissible": ColumnText("whether the orbit or the equilibrium is one of the model", TRUTH),
    "error_estimate": ColumnText("estimated error, relative to the solution's size"),
    "n_unstable": ColumnText("multipliers outside the unit circle, or roots right of the imaginary axis", COUNT),
    "note": ColumnText("why the point is special, or what is to be known of it"),
}
_OF_ORBITS: Mapping[str, ColumnText] = {
    **_POINTS,
    "period": ColumnText("duration of the orbit", unit="{}"),
    "verified": ColumnText("whether a simulation from the orbit's own past confirms it", TRUTH),
    "deviation": ColumnText("how far that simulation was from the orbit, relative to its size"),
    "n_unknowns": ColumnText("unknowns of the discretised orbit"),
}
_OF_EQUILIBRIA: Mapping[str, ColumnText] = {
    **_POINTS,
    "mode": ColumnText("mode in which the equilibrium stays"),
    "counted": ColumnText("whether a count confirms the roots right of the imaginary axis", TRUTH),
    "frequency": ColumnText("imaginary part of the critical roots at a Hopf point", unit="rad/{}"),
    "coefficient": ColumnText("coefficient of the normal form at a Hopf point or a fold"),
}
_OF_ATTRACTORS: Mapping[str, ColumnText] = {
    "index": _POINTS["index"],
    "label": ColumnText("name of the attractor; empty for a motion that failed"),
    "period": ColumnText("period in returns to the section", COUNT),
    "turn": ColumnText("duration of one period", unit="{}"),
    "direction": ColumnText("which way the parameter was carried: up, down, or not"),
    "share": ColumnText("share of the starts that lead there"),
    "share_low": ColumnText("lower limit of the share's interval of 95 %"),
    "share_high": ColumnText("upper limit of the share's interval of 95 %"),
    "lyapunov": ColumnText("largest Lyapunov exponent", unit="1/{}"),
    "lyapunov_error": ColumnText("error of that exponent", unit="1/{}"),
    "note": ColumnText("why a motion failed, or an exponent is not known"),
}
_SPECTRA: Mapping[str, ColumnText] = {
    "index": _POINTS["index"],
    "label": _POINTS["label"],
    "number": ColumnText("number of the value at its point, from 1"),
    "multiplier": ColumnText("Floquet multiplier"),
    "modulus": ColumnText("its modulus"),
    "re": ColumnText("real part of the characteristic root", unit="1/{}"),
    "im": ColumnText("imaginary part of the characteristic root", unit="rad/{}"),
    "residual": ColumnText("residual in the linearised equations, relative to their size"),
}
_OVER_TIME: Mapping[str, ColumnText] = {
    "t": ColumnText("time", unit="{}"),
    "segment": ColumnText("segment of the orbit: its number from 1, or the name that it ends"),
    "mode": ColumnText("mode that holds"),
    "index": _POINTS["index"],
    "label": _OF_ATTRACTORS["label"],
    "settling": ColumnText("time after which it was known where the motion goes", unit="{}"),
}
_OF_EXPLORATIONS: Mapping[str, ColumnText] = {
    "branch": ColumnText("step that holds the branch, or the branch that a motion lies on"),
    "from": ColumnText("what it was found from"),
    "depth": ColumnText("period doublings before it"),
    "curve": ColumnText("kind of special points of a curve in two parameters"),
    "low": ColumnText("lowest value of the parameter"),
    "high": ColumnText("highest value of the parameter"),
    "points": ColumnText("number of points", COUNT),
    "stable": ColumnText("number of points that are stable", COUNT),
    "special": ColumnText("labels of special points"),
    "images": ColumnText("symmetries of the model that give other branches like it"),
    "outcome": ColumnText("how it ended, or why it was not followed"),
    "label": ColumnText("name of a motion that lies on no branch"),
    "motion": ColumnText("what the motion was taken for when it was found"),
    "look": ColumnText("what kind of motion it is"),
    "period": ColumnText("its period; 0 at rest, missing where none was found", unit="{}"),
    "lyapunov": _OF_ATTRACTORS["lyapunov"],
    "lyapunov_error": _OF_ATTRACTORS["lyapunov_error"],
    "image": ColumnText("symmetry by which it lies on the branch"),
    "beside": ColumnText("branch that it is like, which is not known to be stable there"),
    "found": ColumnText("simulations that found it, and their point"),
    "note": ColumnText("what else is to be known"),
    "torus": ColumnText("simulations that follow the torus"),
    "rotation": ColumnText("rotation number, between 0 and 1/2"),
    "rotation_error": ColumnText("error of that number"),
    "locked": ColumnText("the rotation number as a fraction, where the torus is locked to a period"),
    "point": ColumnText("its place among those simulations"),
}
_OF_PRECISION: Mapping[str, ColumnText] = {
    "index": ColumnText("number of the setting; the reference is first"),
    "method": ColumnText("how the delay is discretised"),
    "setting": ColumnText("degree and mesh in words"),
    "degree": ColumnText("degree of the polynomials"),
    "intervals": ColumnText("mesh intervals that were asked for; 0: as the tolerance needs"),
    "n": ColumnText("order of the chain, or nodes of the delay's discretisation"),
    "n_intervals": ColumnText("mesh intervals"),
    "n_unknowns": _OF_ORBITS["n_unknowns"],
    "n_iterations": ColumnText("iterations of Newton's method"),
    "n_steps": ColumnText("steps of the integrator"),
    "memory": ColumnText("memory in bytes"),
    "tolerance": ColumnText("tolerance that was asked for"),
    "error": ColumnText("largest error of the quantities"),
    "distance": ColumnText("distance of the orbit from the reference"),
    "wall": ColumnText("seconds that it took"),
    "wall_low": ColumnText("least seconds that it took"),
    "wall_high": ColumnText("most seconds that it took"),
    "cpu": ColumnText("seconds of CPU time"),
    "note": ColumnText("why a setting failed"),
}
_TEXTS: Mapping[tuple[str, str], Mapping[str, ColumnText]] = {
    **{(kind, table): _OF_ORBITS for kind in ("orbit", "continue") for table in ("points", "special")},
    **{(kind, table): _OF_EQUILIBRIA for kind in ("equilibrium", "equilibria") for table in ("points", "special")},
    **{(kind, "points"): _OF_ATTRACTORS for kind in ("sweep", "basin")},
    **{("explore", table): _OF_EXPLORATIONS for table in ("branches", "unexplained", "motions", "tori")},
    ("precision", "precision"): _OF_PRECISION,
}
# Of any kind of step.
_OF_TABLES: Mapping[str, Mapping[str, ColumnText]] = {
    **dict.fromkeys(("multipliers", "roots"), _SPECTRA),
    **dict.fromkeys(("orbit", "trajectory", "events", "returns", "cells"), _OVER_TIME),
}
_NAMED = {"states": "state", "parameters": "parameter", "monitors": "monitor", "signals": "signal"}
# What names are made of that stand before or after the name of a state, a segment or a quantity.
_AFTER = {"_after": "{} after the reset", "_error": "error of {}"}
_BEFORE = {"lowest_": "lowest value of {}", "highest_": "highest value of {}", "n_": "segments {} in one period"}


def describe_column(step: Step, table: str, name: str) -> ColumnText:
    """Return what a column of a table of ``step`` holds; an empty text for columns of kinds that were added."""
    own = _TEXTS.get((step.kind, table)) or _OF_TABLES.get(table) or _POINTS
    if name in own:
        return own[name]
    for group, what in _NAMED.items():
        if name in (step.meta.get(group) or ()):
            return ColumnText(f"{what} {name}")
    for end, text in _AFTER.items():
        if name.endswith(end):
            return ColumnText(text.format(name.removesuffix(end)))
    for begin, text in _BEFORE.items():
        if name.startswith(begin):
            return ColumnText(text.format(name.removeprefix(begin)))
    return ColumnText("quantity" if name in (step.meta.get("quantities") or ()) else "")


def find_unit(step: Step, table: str, name: str) -> str:
    """Return the unit of a column, empty where the model gives none, or the column is a pure number."""
    units = step.meta.get("units") or {}
    pattern = describe_column(step, table, name).unit
    if pattern:
        return pattern.format(units["t"]) if "t" in units else ""
    bare = name.removesuffix("_after").removeprefix("lowest_").removeprefix("highest_")
    return str(units.get(bare, ""))
