"""Results files made up by hand, so that every picture and table can be compared with what was put in.

The branches lie on simple curves: y = sqrt(K) below the grazing at K = .5 (signature NC C), a straight line above it
(NC), a fold, a period doubling; in two parameters a grazing curve with a cusp and a fold curve.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pddecont.reasons import NO_REASON, make_reason
from pddecont.results import CONTINUE, ORBIT, PRECISION, StepFormat, StepWriter, create_results

PARAMETERS = ("omega", "K", "tau_d")
STATES = ("x", "v")
# What every file has of an orbit, and what only newer ones have.
POINTS = (
    "kind",
    "arclength",
    "parameters",
    "period",
    "stable",
    "admissible",
    "error_estimate",
    "monitors",
    "n_periods",
    "n_unknowns",
    "surfaces",
)
NEW_POINTS = ("n_unstable", "trivial_error")
ROWS = ("time", "states", "segment", "mesh", "signature")
NEW_ROWS = ("multipliers", "reason")
END = make_reason("text", text="reached the end")


# A run of the impact oscillator with every kind of simulation, and a branch in the parameter of its sweep.
SIMULATIONS = {
    "model": "impact_oscillator",
    "effects": {"off": ["feedback"]},
    "set": {"beta": 40},
    "mesh": {"degree": 8, "tol": 1e-09},
    "steps": [
        {
            "name": "t",
            "simulate": {
                "t_end": "200*2*pi/omega",
                "record": {"signals": {"wall": "beta*(x - e)"}},
                "at": {"100": {"a": 0.95}, "200": {"a": 0.9}},
            },
        },
        {"name": "o", "orbit": {"from": "t", "stability": True}},
        {
            "name": "branch",
            "continue": {
                "from": "o",
                "free": ["beta"],
                "range": {"beta": [30, 45]},
                "stability": True,
                "events_along": {"P": "beta - 37"},
            },
        },
        {
            "name": "diagram",
            "sweep": {
                "over": {"beta": [30, 45, 4]},
                "initial": [{"x": 0}, {"x": -0.26, "v": 1.74}],
                "transient": "300*2*pi/omega",
                "lyapunov": True,
            },
        },
        {"name": "plane", "sweep": {"over": {"beta": [30, 45, 3], "a": [0.9, 0.92, 2]}, "transient": "150*2*pi/omega"}},
        {"name": "map", "basin": {"over": {"x": [-2, 1.2, 6], "v": [-2, 2, 5]}, "transient": "300*2*pi/omega"}},
        {
            "name": "other",
            "set": {"beta": 90},
            "basin": {"over": {"x": [-2, 1.2, 6], "v": [-2, 2, 5]}, "transient": "300*2*pi/omega"},
        },
    ],
}
METHODS = ("direct", "chain of order 1")


def point(
    arclength,
    K,
    tau_d,
    top,
    *,
    kind="",
    stable=1,
    admissible=1,
    signature="NC C",
    multipliers=(),
    side=(np.nan, np.nan),
    reason=NO_REASON,
    trivial_error=np.nan,
    n_periods=1,
):
    """Return what is put into a file of one point; ``side`` is in the order of the free parameters."""
    return {
        "arclength": arclength,
        "parameters": [0.8, K, tau_d],
        "monitors": [top],
        "kind": kind.encode(),
        "stable": stable,
        "admissible": admissible,
        "signature": signature,
        "multipliers": np.array(multipliers, dtype=complex),
        "side": side,
        "reason": reason,
        "trivial_error": trivial_error,
        "n_periods": n_periods,
        "period": 7.0 * n_periods,
        "error_estimate": 1e-9,
        "n_unknowns": 100,
        "surfaces": [[1.0, 0.0, 0.9]],
        "n_unstable": -1 if stable < 0 else sum(abs(m) > 1 for m in multipliers),
    }


def circle(signature):
    """Return the rows of orbits of an orbit on the unit circle, degree 2, as many base points for each segment."""
    names = signature.split()
    t = np.linspace(0.0, 7.0, 5 * len(names))
    return {
        "time": t,
        "states": np.column_stack([np.cos(t * 0.9), np.sin(t * 0.9)]),
        "segment": np.repeat(np.arange(len(names)), 5),
        "mesh": np.array([2.0]),
        "signature": np.frombuffer(signature.encode(), dtype=np.uint8),
    }


def add(
    path: Path, name: str, rows, *, kind="continue", free=("K",), curve="", followed=NO_REASON, new=True, side=False
):
    """Append a step to the file: of a curve which kind of point, and why that is one, is followed.

    ``new`` False leaves out what older files do not have.
    """
    points = (*POINTS, *(NEW_POINTS if new else ()), *(("side",) if side else ()))
    whole = CONTINUE if kind == "continue" else ORBIT
    step_format = keep(whole, points, (*ROWS, *(NEW_ROWS if new else ())))
    meta = {
        "parameters": PARAMETERS,
        "states": STATES,
        "monitors": ("top",),
        "events": ("impact",),
        "model": "synthetic",
        "free": free if kind == "continue" else [],
        "directions": 1,
    }
    if new:
        meta |= {"curve": curve, "curve_reason": followed.to_json()}
    with StepWriter(path, name, step_format, meta) as writer:
        for row in rows:
            m = row["multipliers"]
            shape = circle(row["signature"]) | ({"multipliers": np.column_stack([m.real, m.imag])} if new else {})
            writer.append({key: row[key] for key in points}, shape, row["reason"])
        writer.terminate(END)


def keep(whole, points, rows):
    """Return a kind's format with some of its arrays alone."""
    return StepFormat(whole.kind, {key: whole.points[key] for key in points}, {key: whole.orbits[key] for key in rows})


def gain(tau_d=3.8):
    """Return a branch: stable NC C, unstable from a fold at K = .3, grazing at K = .5, then NC, not admissible from K =
    .8.
    """
    rows = []
    for k, K in enumerate(np.linspace(0.1, 0.9, 33)):
        top = np.sqrt(K) + 0.1 * (tau_d - 3.8)
        kind = {8: "LP", 16: "GR"}.get(k, "")
        m = [0.7 + K, *(np.array([0.5 + 0.3j, 0.5 - 0.3j]) * (1 + K))]
        rows.append(
            point(
                float(k),
                K,
                tau_d,
                top,
                kind=kind,
                stable=int(K < 0.3),
                admissible=int(K < 0.8),
                signature="NC C" if k <= 16 else "NC",
                multipliers=sorted(m, key=abs, reverse=True),
            )
        )
    return rows


def doubled():
    """Return a stable branch with twice the period."""
    return [
        point(
            float(k),
            K,
            3.8,
            np.sqrt(K) + 0.5 * (K - 0.2),
            kind="PD" if k == 0 else "",
            signature="NC C NC C",
            multipliers=[-0.4],
            n_periods=2,
        )
        for k, K in enumerate(np.linspace(0.2, 0.6, 12))
    ]


def grazing_curve():
    """Return a grazing curve tau_d = 3 + 4 (K - .5)^2 in (tau_d, K), kept above it, with a double grazing in the
    middle.
    """
    rows = []
    for k, K in enumerate(np.linspace(0.1, 0.9, 41)):
        kind = "GG" if k == 20 else ""
        side = (1.0, -8.0 * (K - 0.5)) if not kind else (np.nan, np.nan)
        rows.append(
            point(
                float(k),
                K,
                3 + 4 * (K - 0.5) ** 2,
                np.sqrt(K),
                kind=kind,
                stable=int(K < 0.5),
                signature="NC C",
                side=side,
            )
        )
    return rows


def fold_curve():
    """Return a fold curve K = .2 + .1 (tau_d - 3), the orbits to the right of it, in (K, tau_d); two resonances close
    together.
    """
    return [
        point(float(k), 0.2 + 0.1 * (t - 3), t, 0.5, kind={10: "R1", 11: "R2"}.get(k, ""), side=(1.0, -0.1))
        for k, t in enumerate(np.linspace(3, 3.6, 31))
    ]


def write_all(path: Path) -> Path:
    """Write a file with every kind of step."""
    create_results(path, "model", "run", "run.yaml", "{}")
    add(path, "orbit", gain()[:1], kind="orbit")
    add(path, "in_delay", [point(float(k), 0.3, t, 1.0) for k, t in enumerate(np.linspace(3, 4, 9))], free=("tau_d",))
    add(path, "in_gain", gain())
    add(path, "doubled", doubled())
    add(path, "grazing", grazing_curve(), free=("tau_d", "K"), curve="GR", side=True)
    add(path, "folds", fold_curve(), free=("K", "tau_d"), curve="LP", side=True)
    return path


def write_old(path: Path) -> Path:
    """Write a file as the first version did: without any of the new columns."""
    create_results(path, "model", "run", "run.yaml", "{}")
    rows = [r | {"stable": -1} for r in gain()]
    add(path, "orbit", rows[:1], kind="orbit", new=False)
    add(path, "in_gain", rows[:17], new=False)
    return path


def add_precision(path: Path, name: str, K: float, order: float):
    """Append a step that compares two methods: errors fall as N^-order, costs grow as N; Dist(N) of chains is 1/N."""
    numbers = {
        "degree": 2,
        "intervals": 4,
        "n": 0,
        "n_intervals": 4,
        "n_unknowns": 100,
        "n_iterations": 3,
        "n_steps": 0,
    }
    meta = {
        "parameters": PARAMETERS,
        "states": ("x", "v"),
        "quantities": ("top",),
        "model": "synthetic",
        "ends": [[1.0, 0.0], [0.0, 1.0]],
    }
    with StepWriter(path, name, keep(PRECISION, PRECISION.points, ("states",)), meta) as writer:
        for method in ("reference", *METHODS):
            for n in (4, 8, 16, 32) if method != "reference" else (64,):
                error = 1e-12 if method == "reference" else n**-order
                row = numbers | {"n": n if method == METHODS[1] else 0, "n_unknowns": 10 * n, "memory": 1000 * n}
                row |= {"method": method.partition(" ")[0].encode(), "order": int(method == METHODS[1])}
                row |= {"tracked": 1, "explicit": 0, "parameters": [0.8, K, 3.8]}
                row |= {"values": [1.0], "errors": [error], "error": error, "tolerance": 1e-6, "distance": 1.0 / n}
                row |= {"wall": 1.0 * n, "wall_low": 0.9 * n, "wall_high": 1.2 * n, "cpu": 0.5 * n}
                writer.append(row, {"states": circle("NC C")["states"] * (1.0 + error)})
        writer.terminate(END)


def write_precision(path: Path) -> Path:
    """Write a file with two comparisons at different parameters."""
    create_results(path, "model", "run", "run.yaml", "{}")
    add_precision(path, "coarse", 0.2, 2.0)
    add_precision(path, "fine", 0.3, 4.0)
    return path
