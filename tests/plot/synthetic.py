"""Results files made up by hand, so that every picture and table can be compared with what was put in.

The branches lie on simple curves: y = sqrt(K) below the grazing at K = .5 (signature NC C), a straight line above it (NC), a fold,
a period doubling; in two parameters a grazing curve with a cusp and a fold curve.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pddecont.results.layout import Column, StepSpec
from pddecont.results.writer import StepWriter, create

PARAMETERS = ("omega", "K", "tau_d")
POINTS = {
    "kind": Column("S2"), "arclength": Column("f8"), "parameters": Column("f8", (3,)), "period": Column("f8"),
    "stable": Column("i1"), "admissible": Column("i1"), "error_estimate": Column("f8"), "monitors": Column("f8", (1,)),
    "n_periods": Column("i8"), "n_unknowns": Column("i8"), "surfaces": Column("f8", (1, 3)),
}  # fmt: skip
NEW = {"n_unstable": Column("i4"), "trivial_error": Column("f8"), "note": Column("S32")}
ORBITS = {"time": Column("f8"), "states": Column("f8", (2,)), "segment": Column("i4"), "mesh": Column("f8"), "signature": Column("u1")}


def point(arclength, K, tau_d, top, *, kind="", stable=1, admissible=1, signature="NC C", multipliers=(), side=(np.nan, np.nan),
          note="", trivial_error=np.nan, n_periods=1):
    """Return what is put into a file of one point; ``side`` is in the order of the free parameters."""
    return {"arclength": arclength, "parameters": [0.8, K, tau_d], "monitors": [top], "kind": kind.encode(), "stable": stable,
            "admissible": admissible, "signature": signature, "multipliers": np.array(multipliers, dtype=complex), "side": side,
            "note": note.encode(), "trivial_error": trivial_error, "n_periods": n_periods, "period": 7.0 * n_periods,
            "error_estimate": 1e-9, "n_unknowns": 100, "surfaces": [[1.0, 0.0, 0.9]],
            "n_unstable": -1 if stable < 0 else sum(abs(m) > 1 for m in multipliers)}  # fmt: skip


def circle(signature):
    """Return the rows of orbits of an orbit on the unit circle, degree 2, as many base points for each segment."""
    names = signature.split()
    t = np.linspace(0.0, 7.0, 5 * len(names))
    return {"time": t, "states": np.column_stack([np.cos(t * 0.9), np.sin(t * 0.9)]), "segment": np.repeat(np.arange(len(names)), 5),
            "mesh": np.array([2.0]), "signature": np.frombuffer(signature.encode(), dtype=np.uint8)}  # fmt: skip


def add(path: Path, name: str, rows, *, kind="continue", free=("K",), curve="", new=True, side=False):
    """Append a step to the file; ``new`` False leaves out what older files do not have."""
    columns = POINTS | (NEW if new else {}) | ({"side": Column("f8", (2,))} if side else {})
    orbits = ORBITS | ({"multipliers": Column("f8", (2,))} if new else {})
    meta = {"parameters": PARAMETERS, "states": ("x", "v"), "monitors": ("top",), "events": ("impact",), "model": "synthetic",
            "free": free if kind == "continue" else [], "directions": 1}  # fmt: skip
    with StepWriter(path, StepSpec(name, kind, columns, orbits, meta | ({"curve": curve} if new else {}))) as writer:
        for row in rows:
            m = row["multipliers"]
            shape = circle(row["signature"]) | ({"multipliers": np.column_stack([m.real, m.imag])} if new else {})
            writer.append({k: row[k] for k in columns}, shape)
        writer.terminate("reached the end")


def gain(tau_d=3.8):
    """Return a branch: stable NC C, unstable from a fold at K = .3, grazing at K = .5, then NC, not admissible from K = .8."""
    rows = []
    for k, K in enumerate(np.linspace(0.1, 0.9, 33)):
        top = np.sqrt(K) + 0.1 * (tau_d - 3.8)
        kind = {8: "LP", 16: "GR"}.get(k, "")
        m = [0.7 + K, *(np.array([0.5 + 0.3j, 0.5 - 0.3j]) * (1 + K))]
        rows.append(point(float(k), K, tau_d, top, kind=kind, stable=int(K < 0.3), admissible=int(K < 0.8),
                          signature="NC C" if k <= 16 else "NC", multipliers=sorted(m, key=abs, reverse=True)))  # fmt: skip
    return rows


def doubled():
    """Return a stable branch with twice the period."""
    return [point(float(k), K, 3.8, np.sqrt(K) + 0.5 * (K - 0.2), kind="PD" if k == 0 else "", signature="NC C NC C",
                  multipliers=[-0.4], n_periods=2) for k, K in enumerate(np.linspace(0.2, 0.6, 12))]  # fmt: skip


def grazing_curve():
    """Return a grazing curve tau_d = 3 + 4 (K - .5)^2 in (tau_d, K), kept above it, with a double grazing in the middle."""
    rows = []
    for k, K in enumerate(np.linspace(0.1, 0.9, 41)):
        kind = "GG" if k == 20 else ""
        side = (1.0, -8.0 * (K - 0.5)) if not kind else (np.nan, np.nan)
        rows.append(point(float(k), K, 3 + 4 * (K - 0.5) ** 2, np.sqrt(K), kind=kind, stable=int(K < 0.5), signature="NC C", side=side))
    return rows


def fold_curve():
    """Return a fold curve K = .2 + .1 (tau_d - 3), the orbits to the right of it, in (K, tau_d); two resonances close together."""
    return [point(float(k), 0.2 + 0.1 * (t - 3), t, 0.5, kind={10: "R1", 11: "R2"}.get(k, ""), side=(1.0, -0.1))
            for k, t in enumerate(np.linspace(3, 3.6, 31))]  # fmt: skip


def write_all(path: Path) -> Path:
    """Write a file with every kind of step."""
    create(path, "model", "run", "run.yaml", "{}")
    add(path, "orbit", gain()[:1], kind="orbit")
    add(path, "in_delay", [point(float(k), 0.3, t, 1.0) for k, t in enumerate(np.linspace(3, 4, 9))], free=("tau_d",))
    add(path, "in_gain", gain())
    add(path, "doubled", doubled())
    add(path, "grazing", grazing_curve(), free=("tau_d", "K"), curve="GR", side=True)
    add(path, "folds", fold_curve(), free=("K", "tau_d"), curve="LP", side=True)
    return path


def write_old(path: Path) -> Path:
    """Write a file as the first version did: without any of the new columns."""
    create(path, "model", "run", "run.yaml", "{}")
    rows = [r | {"stable": -1} for r in gain()]
    add(path, "orbit", rows[:1], kind="orbit", new=False)
    add(path, "in_gain", rows[:17], new=False)
    return path
