"""What the files beside this one expect of a model's own run, and how their expressions are evaluated.

Each entry has ``what``, ``at`` (STEP, STEP/LABEL, STEP/* for every point, STEP/0 for the first along the branch),
``quantity`` and ``value``: expressions in the parameters, monitors and ``period`` of the point, its multipliers
``mu1``, ``mu2``, .. by falling modulus, the time ``start`` at which its first segment begins, the states ``NAME_start``
there, and what ``let``, ``solve`` (name: [expression that is zero, lowest, highest]) and ``then`` define. At equilibria
there are the states by their own names, the roots ``root1``, ``root2``, .. by falling real part, ``n_unstable``,
``frequency`` and ``coefficient``; of a simulation the parameters, ``event_time``, ``NAME_before`` the events and
``NAME_end``. ``source`` says where the value is from, ``because`` why ``tol`` is what it is;
``independent`` names the test that calculates the value again.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import lambertw

from pddecont.model import parse_document

FOLDER = Path(__file__).parent
FUNCTIONS = {
    name: getattr(np, name)
    for name in (
        "sin",
        "cos",
        "tan",
        "arctan",
        "arctan2",
        "arccos",
        "mod",
        "arctanh",
        "sinh",
        "tanh",
        "exp",
        "log",
        "sqrt",
        "abs",
        "max",
        "min",
        "sum",
        "sort",
        "pi",
        "array",
        "block",
        "zeros",
        "eye",
        "trace",
        "real",
        "angle",
        "linspace",
    )
}
FUNCTIONS |= {
    "expm": expm,
    "det": np.linalg.det,
    "eigvals": np.linalg.eigvals,
    "solved": np.linalg.solve,
    "lambertw": lambertw,
    "integral": lambda f, a, b: quad(f, a, b, epsabs=1e-13, epsrel=1e-13)[0],
    "range": range,
}


def entries(name):
    """Return the entries of a model's file."""
    path = FOLDER / f"{name}.yaml"
    return parse_document(path.read_text(), str(path)).data["expected"]


def entry(name, what):
    """Return one entry of a model's file."""
    return next(e for e in entries(name) if e["what"] == what)


def points(results, at):
    """Return the names known at each point that ``at`` speaks of."""
    name, _, label = at.partition("/")
    step = results.step(name)
    if step.kind == "simulate":
        return [_trajectory(step)]
    rows = step.order if label == "*" else [step.order[0] if label in ("", "0") else step.row(label)]
    return [_point(step, i) for i in rows]


def _point(step, i):
    names = dict(zip(step.meta["parameters"], step.points["parameters"][i], strict=True))
    names |= dict(zip(step.meta["monitors"], step.points["monitors"][i], strict=True))
    rows = step.orbit(i)
    if "roots" in rows:
        return names | _equilibrium(step, i)
    names |= {f"mu{k}": complex(*pair) for k, pair in enumerate(rows["multipliers"], 1)}
    names |= {f"{state}_start": value for state, value in zip(step.meta["states"], rows["states"][0], strict=True)}
    return names | {"period": step.points["period"][i], "start": rows["time"][0]}


def _equilibrium(step, i):
    names = dict(zip(step.meta["states"], step.points["states"][i], strict=True))
    names |= {f"root{k}": complex(*pair) for k, pair in enumerate(step.orbit(i)["roots"], 1)}
    return names | {key: step.points[key][i] for key in ("n_unstable", "frequency", "coefficient")}


def _trajectory(step):
    rows = step.orbit(0)
    names = dict(zip(step.meta["parameters"], step.points["parameters"][0], strict=True))
    names |= {"event_time": rows["event_time"]}
    for k, state in enumerate(step.meta["states"]):
        names |= {f"{state}_before": rows["before"][:, k], f"{state}_end": rows["states"][-1, k]}
    return names


def evaluated(text, names):
    """Return what an expression of a file stands for."""
    return eval(str(text), {"__builtins__": {}, **FUNCTIONS, **names})


def both(item, names):
    """Return the quantity and the value that an entry expects at a point."""
    names = dict(names)
    for name, text in item.get("let", {}).items():
        names[name] = evaluated(text, names)
    for name, (text, low, high) in item.get("solve", {}).items():

        def miss(x, text=text, name=name):
            return evaluated(text, {**names, name: x})

        names[name] = brentq(miss, evaluated(low, names), evaluated(high, names), xtol=1e-14, rtol=1e-14)
    for name, text in item.get("then", {}).items():
        names[name] = evaluated(text, names)
    return evaluated(item["quantity"], names), evaluated(item["value"], names)


def value(model, what):
    """Return an expected number, and how far another calculation may be from it: each may be off by its tolerance."""
    item = entry(model, what)
    return float(item["value"]), 2 * item["tol"]
