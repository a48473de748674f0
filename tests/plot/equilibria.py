"""A results file with equilibria whose numbers are known, the orbits born of them, and curves in two parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pddecont.equilibrium import CURVE_NAMES, NAMES
from pddecont.reasons import NO_REASON, make_reason
from pddecont.results import CONTINUE, EQUILIBRIA, EQUILIBRIUM, StepWriter, create_results
from tests.plot.synthetic import NEW_POINTS, NEW_ROWS, PARAMETERS, POINTS, ROWS, STATES, add, fold_curve, keep, point

MODES = ("low", "high")
FOUND, NEAR = make_reason("search"), make_reason("equilibrium")
UP = make_reason("range", direction=1, detail="range", parameter="K", value=0.9)


def rest(
    k,
    K,
    x,
    roots,
    *,
    tau_d=3.8,
    v=0.0,
    kind="",
    mode="low",
    admissible=1,
    side=(np.nan, np.nan),
    counted=1,
    reason=NO_REASON,
):
    """Return what is put into a file of one equilibrium: its number along the branch, and all its roots."""
    n_unstable = int(np.sum(np.real(roots) > 0.0))
    return (
        {
            "kind": kind.encode(),
            "arclength": float(k),
            "parameters": [0.8, K, tau_d],
            "states": [x, v],
            "monitors": [x],
            "stable": int(n_unstable == 0 and admissible) if counted else -1,
            "admissible": admissible,
            "counted": counted,
            "n_unstable": n_unstable if counted else -1,
            "frequency": np.nan,
            "coefficient": np.nan,
            "error_estimate": 1e-15,
            "n_iterations": 2,
            "step": 0.1,
            "n_unknowns": 3,
            "unexplained": 0,
            "side": side,
        },
        {
            "unknowns": np.array([x, v, K]),
            "tangent": np.zeros(3),
            "roots": np.column_stack([np.real(roots), np.imag(roots)]),
            "residual": np.zeros(len(roots)),
            "signature": np.frombuffer(mode.encode(), dtype=np.uint8),
        },
        reason,
    )


def write(path: Path, name: str, rows, *, kind="equilibria", free=("K",), curve="", ending=UP):
    """Append a step with equilibria to a file."""
    meta = {
        "parameters": PARAMETERS,
        "states": STATES,
        "monitors": ("top",),
        "modes": MODES,
        "kinds": {**NAMES, **CURVE_NAMES, "EQ": "equilibrium"},
        "free": list(free) if kind == "equilibria" else [],
        "directions": 1,
        "curve": curve,
        "curve_reason": "",
    }
    if kind == "equilibrium" and ending == FOUND:
        meta |= {"search": {"x": [-2, 2], "v": [-2, 2]}, "undecided": []}
    with StepWriter(path, name, EQUILIBRIA if kind == "equilibria" else EQUILIBRIUM, meta) as writer:
        for points, arrays, reason in rows:
            writer.append(points, arrays, reason)
        writer.terminate(ending)


def three():
    """Return a stable equilibrium, an unstable one, and a virtual one."""
    return [
        rest(0, 0.2, -1.0, [-0.1 + 1j, -0.1 - 1j, -3.0], v=0.5, kind="EQ"),
        rest(0, 0.2, 0.0, [0.2, -1.0], v=-0.5, kind="EQ"),
        rest(0, 0.2, 1.0, [-0.2, -1.0], v=1.5, kind="EQ", mode="high", admissible=0),
    ]


def branch():
    """Return equilibria x = K with roots K - 0.3 +- i: Hopf at 0.3, mode high from 0.5 on, virtual from 0.8 on."""
    rows = []
    for k, K in enumerate(np.round(np.linspace(0.1, 0.9, 33), 12)):
        kind = {8: "HB", 16: "BE"}.get(k, "")
        roots = [K - 0.3 + 1j, K - 0.3 - 1j, -2.0 - K, -1000.0]
        mode = "low" if k < 17 else "high"
        rows.append(rest(k, K, K, roots, kind=kind, mode=mode, admissible=int(K < 0.8 - 1e-9)))
    return rows


def orbit_around(K):
    """Return the rows of an orbit x = K + r (s^2 - 0.6 s), v = 0, r = K - 0.3: x from K - 0.09 r to K + 0.4 r."""
    s = np.linspace(0.0, 1.0, 5)
    return {
        "time": 7.0 * s,
        "states": np.column_stack([K + (K - 0.3) * (s**2 - 0.6 * s), 0.0 * s]),
        "segment": np.zeros(5, int),
        "mesh": np.array([2.0]),
        "signature": np.frombuffer(b"round", dtype=np.uint8),
        "multipliers": np.array([[0.5, 0.0]]),
    }


def write_orbits(path: Path, name: str) -> None:
    """Append a branch of stable orbits from K = 0.3 to 0.7 to a file."""
    meta = {"parameters": PARAMETERS, "states": STATES, "monitors": ("top",), "events": ("impact",), "free": ["K"]}
    meta |= {"directions": 1, "curve": "", "curve_reason": ""}
    with StepWriter(path, name, keep(CONTINUE, (*POINTS, *NEW_POINTS), (*ROWS, *NEW_ROWS)), meta) as writer:
        for k, K in enumerate(np.linspace(0.3, 0.7, 9)):
            row = point(float(k), K, 3.8, 1.4 * K - 0.12)
            writer.append({key: row[key] for key in (*POINTS, *NEW_POINTS)}, orbit_around(K))
        writer.terminate(UP)


def hopf_curve():
    """Return Hopf points tau_d = 3 + K, the roots beside them stable below it and, after HH at K = 0.5, unstable."""
    rows = []
    for k, K in enumerate(np.linspace(0.1, 0.9, 33)):
        roots = [0.2 * (K - 0.5) + 2j, 0.2 * (K - 0.5) - 2j] if k != 16 else [2j, -2j]
        rows.append(rest(k, K, K, roots, tau_d=3.0 + K, kind="HH" if k == 16 else "", side=(1.0, -1.0)))
    return rows


def fold_points():
    """Return folds tau_d = 3.9 - K, with one other unstable root; equilibria exist below it."""
    return [
        rest(k, K, K, [0.5, -1.0], tau_d=3.9 - K, side=(-1.0, -1.0)) for k, K in enumerate(np.linspace(0.1, 0.35, 21))
    ]


def boundary_points():
    """Return boundary equilibria tau_d = 3.1 of mode low, which lie in it above."""
    return [rest(k, K, K, [-1.0], tau_d=3.1, side=(0.0, 1.0)) for k, K in enumerate(np.linspace(0.4, 0.9, 11))]


def write_resting(path: Path) -> Path:
    """Write the file."""
    create_results(path, "model", "run", "run.yaml", "{}")
    write(path, "all", three(), kind="equilibrium", ending=FOUND)
    write(path, "one", three()[1:2], kind="equilibrium", ending=NEAR)
    write(path, "resting", branch())
    write_orbits(path, "cycles")
    both = {"free": ("K", "tau_d")}
    add(path, "orbit_folds", fold_curve(), **both, curve="LP", side=True)
    write(path, "folds", fold_points(), **both, curve="LP")
    write(path, "boundaries", boundary_points(), **both, curve="BE")
    write(path, "hopf", hopf_curve(), **both, curve="HB")
    return path
