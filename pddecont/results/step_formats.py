"""The formats of the program's own kinds of steps, and of those that others make known."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.results.format import Arrays, Column, StepFormat

FLOAT, COUNT, SMALL, TRUTH = Column("f8"), Column("i8"), Column("i4"), Column("i1")
KIND = Column("S8")
PARAMETERS, STATES = Column("f8", ("parameters",)), Column("f8", ("states",))
# A reason as JSON, byte by byte, so that names of any length fit; empty for none.
REASON = Column("u1")

ORBIT_POINTS = {
    "kind": KIND,
    "arclength": FLOAT,
    "parameters": PARAMETERS,
    "period": FLOAT,
    "stable": TRUTH,
    "admissible": TRUTH,
    "verified": TRUTH,
    "deviation": FLOAT,
    "error_estimate": FLOAT,
    "monitors": Column("f8", ("monitors",)),
    "clearance": FLOAT,
    "n_iterations": COUNT,
    "step": FLOAT,
    "n_periods": COUNT,
    "phase": FLOAT,
    "n_unknowns": COUNT,
    "surfaces": Column("f8", ("events", ("states", 1))),
    "n_unstable": SMALL,
    "trivial_error": FLOAT,
    "side": Column("f8", (2,)),
}
ORBIT_ROWS = {
    "time": FLOAT,
    "states": STATES,
    "segment": SMALL,
    "unknowns": FLOAT,
    "tangent": FLOAT,
    "mesh": FLOAT,
    "signature": REASON,
    "multipliers": Column("f8", (2,)),
    "residual": FLOAT,
    "delayed": Column("f8", ("delayed",)),
    "reason": REASON,
}
EQUILIBRIUM_POINTS = {
    "kind": KIND,
    "arclength": FLOAT,
    "parameters": PARAMETERS,
    "states": STATES,
    "stable": TRUTH,
    "admissible": TRUTH,
    "counted": TRUTH,
    "n_unstable": SMALL,
    "frequency": FLOAT,
    "coefficient": FLOAT,
    "error_estimate": FLOAT,
    "monitors": Column("f8", ("monitors",)),
    "n_iterations": COUNT,
    "step": FLOAT,
    "n_unknowns": COUNT,
    "unexplained": SMALL,
    "side": Column("f8", (2,)),
}
# The mode stands where the signature of an orbit does.
EQUILIBRIUM_ROWS = {
    "unknowns": FLOAT,
    "tangent": FLOAT,
    "roots": Column("f8", (2,)),
    "residual": FLOAT,
    "signature": REASON,
    "reason": REASON,
}
ATTRACTOR_POINTS = {
    "kind": KIND,
    "parameters": PARAMETERS,
    "period": SMALL,
    "turn": FLOAT,
    "n_segments": Column("i8", ("segments",)),
    "lyapunov": FLOAT,
    "lyapunov_error": FLOAT,
}
ATTRACTOR_ROWS = {"returns": STATES, "return_slopes": STATES, "return_time": FLOAT, "memory": FLOAT, "reason": REASON}
RETURNS = ("returns", "return_slopes", "return_time")
ROOTS = ("roots", "residual")
BASE_POINTS = ("time", "states", "segment", "delayed")


def _check_signatures(meta: Mapping[str, Any], points: Arrays, orbits: Arrays) -> None:
    if np.any(orbits.get("signature", np.empty(0, np.uint8)) > 127):
        raise ResultsError("a signature is not text")


def _check_trajectory(meta: Mapping[str, Any], points: Arrays, orbits: Arrays) -> None:
    for name, listed in (("mode", "modes"), ("event_segment", "segments")):
        if name in orbits and listed in meta:
            check_within(name, orbits[name], 0, len(meta[listed]))
    if len(next(iter(points.values()), [])) > 1:
        raise ResultsError("a simulation has one row")


def _check_sweep(meta: Mapping[str, Any], points: Arrays, orbits: Arrays) -> None:
    check_within("direction", points.get("direction", np.zeros(0, int)), -1, 2)


def _check_basin(meta: Mapping[str, Any], points: Arrays, orbits: Arrays) -> None:
    if not {"line", "label"} <= {*points, *orbits}:
        return
    columns, ends, lines = len(meta.get("x", [])), np.diff(orbits["label_end"], prepend=0), points["line"]
    check_within("line", lines, -1, len(meta.get("y", [])))
    check_within("label", orbits["label"], 0, int(np.sum(lines < 0)))
    if np.any(ends != np.where(lines < 0, 0, columns)) or np.any(np.diff(lines[lines >= 0], prepend=-1) != 1):
        raise ResultsError("the lines of the basin are not those of its grid")


def _check_precision(meta: Mapping[str, Any], points: Arrays, orbits: Arrays) -> None:
    if not meta.get("ends", True) and np.any(np.isfinite(points.get("distance", np.empty(0)))):
        raise ResultsError("'ends' is empty, but distances from what it should hold are there")


def check_within(name: str, values: NDArray[Any], low: int, high: int) -> None:
    """Raise ResultsError if whole numbers lie outside ``low`` to ``high`` - 1."""
    if len(values) and not (low <= values.min() and values.max() < high):
        raise ResultsError(f"'{name}' holds numbers outside {low} to {high - 1}")


ORBIT = StepFormat("orbit", ORBIT_POINTS, ORBIT_ROWS, (BASE_POINTS,), check=_check_signatures)
CONTINUE = StepFormat(
    "continue",
    {**ORBIT_POINTS, "unexplained": SMALL},
    ORBIT_ROWS,
    (BASE_POINTS,),
    has_branch=True,
    check=_check_signatures,
)
EQUILIBRIUM = StepFormat("equilibrium", EQUILIBRIUM_POINTS, EQUILIBRIUM_ROWS, (ROOTS,), check=_check_signatures)
EQUILIBRIA = StepFormat(
    "equilibria", EQUILIBRIUM_POINTS, EQUILIBRIUM_ROWS, (ROOTS,), has_branch=True, check=_check_signatures
)
SIMULATE = StepFormat(
    "simulate",
    {"parameters": PARAMETERS, "t_end": FLOAT, "n_steps": COUNT, "n_events": COUNT},
    {
        "time": FLOAT,
        "states": STATES,
        "mode": SMALL,
        "event_time": FLOAT,
        "event_segment": SMALL,
        "before": STATES,
        "after": STATES,
        "signals": Column("f8", ("signals",)),
    },
    (("time", "states", "mode", "signals"), ("event_time", "event_segment", "before", "after")),
    check=_check_trajectory,
)
SWEEP = StepFormat(
    "sweep",
    {**ATTRACTOR_POINTS, "chunk": COUNT, "cell": COUNT, "direction": SMALL, "share": FLOAT},
    ATTRACTOR_ROWS,
    (RETURNS,),
    {"free": (1, 2)},
    check=_check_sweep,
)
BASIN = StepFormat(
    "basin",
    {**ATTRACTOR_POINTS, "line": COUNT},
    {**ATTRACTOR_ROWS, "label": SMALL, "settling": FLOAT},
    (RETURNS, ("label", "settling")),
    {"over": (2, 2)},
    check=_check_basin,
)
PRECISION = StepFormat(
    "precision",
    {
        "method": Column("S16"),
        "tracked": TRUTH,
        "order": SMALL,
        "explicit": TRUTH,
        "degree": SMALL,
        "intervals": SMALL,
        "tolerance": FLOAT,
        "n": COUNT,
        "values": Column("f8", ("quantities",)),
        "errors": Column("f8", ("quantities",)),
        "error": FLOAT,
        "distance": FLOAT,
        "wall": FLOAT,
        "wall_low": FLOAT,
        "wall_high": FLOAT,
        "cpu": FLOAT,
        "memory": COUNT,
        "n_unknowns": COUNT,
        "n_intervals": COUNT,
        "n_iterations": COUNT,
        "n_steps": COUNT,
        "parameters": PARAMETERS,
    },
    {"time": FLOAT, "states": STATES, "reason": REASON},
    (("time", "states"),),
    check=_check_precision,
)
# A row a branch, then a row a motion that was compared with the branches; ``reason`` says what became of each.
EXPLORE = StepFormat(
    "explore",
    {
        "kind": KIND,
        "parameters": PARAMETERS,
        "period": FLOAT,
        "lowest": STATES,
        "highest": STATES,
        "lyapunov": FLOAT,
        "lyapunov_error": FLOAT,
    },
    {"reason": REASON},
    name_lists={"free": (1, 2)},
)
_FORMATS = {f.kind: f for f in (SIMULATE, EQUILIBRIUM, ORBIT, EQUILIBRIA, CONTINUE, SWEEP, BASIN, PRECISION, EXPLORE)}


def register_format(step_format: StepFormat) -> None:
    """Make the format of a kind of step known.

    Raises
    ------
    ValueError
        If another kind has its name.
    """
    if _FORMATS.setdefault(step_format.kind, step_format) is not step_format:
        raise ValueError(f"there is a kind of step '{step_format.kind}' already")


def forget_format(kind: str) -> None:
    """Forget the format of a kind that :func:`register_format` made known."""
    _FORMATS.pop(kind, None)


def find_format(kind: str) -> StepFormat:
    """Return the format of a kind of step; raise ResultsError for a kind that is not known."""
    if kind not in _FORMATS:
        raise ResultsError(f"steps of kind '{kind[:40]}' are not known (kinds: {', '.join(_FORMATS)})")
    return _FORMATS[kind]
