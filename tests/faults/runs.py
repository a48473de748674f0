"""Short runs of each kind, and what is compared of their results files."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys

import h5py
import numpy as np

from pddecont.model import parse_document
from pddecont.steps import load_run_plan
from tests.conftest import ROOT
from tests.runs import change, to_yaml

MODEL = {
    "name": "quick",
    "states": ["x", "v"],
    "parameters": {"omega": 2, "c": 0.1, "wall": 0.2, "r": 0.8, "K": 0.1, "tau": 0.7},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v - x + K*x(t - tau)"}},
    "events": {"hit": "x - wall"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {"flight": {"mode": "free", "event": "hit", "direction": "rising", "reset": "bounce", "to": "free"}},
    "run": {"mesh": {"degree": 3, "intervals": 6}, "monitors": {"top": "max(x)", "speed": "at(flight, v)"}},
}
LOOSE = {"rtol": 1e-5, "atol": 1e-7}
TRANSIENT = {"t_end": "40*pi", "record": {"from": "36*pi"}, "rtol": 1e-6, "atol": 1e-8}
START = [{"name": "transient", "simulate": TRANSIENT}, {"name": "orbit", "orbit": {"from": "transient"}}]
SETTLING = {"transient": "40*pi", "max_period": 4, **LOOSE}
UP = {
    "from": "orbit",
    "free": ["wall"],
    "range": {"wall": [0.17, 0.25]},
    "direction": "up",
    "step": {"initial": 0.1, "max": 0.2},
    "events_along": {"u": "wall - 0.22"},
}
CURVE = {
    "from": {"step": "first", "point": "UF1"},
    "free": ["wall", "r"],
    "range": {"wall": [0.1, 0.3], "r": [0.79, 0.81]},
    "events_along": {"u": "wall - 0.22"},
    "step": {"initial": 0.2, "max": 0.4},
}
PRECISION = {
    "from": "orbit",
    "quantities": {"top": "max(x)"},
    "methods": [{"method": "direct"}, {"method": "chain", "order": 2, "n": [5, 10]}],
    "degrees": [3],
    "intervals": [4, 6, 8],
    "repeats": 1,
}
BRANCH = {"from": "orbit", "free": ["wall"], "range": {"wall": [0.18, 0.22]}, "step": {"initial": 0.3, "max": 0.3}}
# Steps of a run of each kind; the last of them is named so.
KINDS = {
    "simulate": [{"name": "last", "simulate": {"t_end": "60*pi", **LOOSE}}],
    "orbit": [START[0], {"name": "last", "orbit": {"from": "transient"}}],
    "continue": [*START, {"name": "last", "continue": BRANCH}],
    "curve": [*START, {"name": "first", "continue": UP}, {"name": "last", "continue": CURVE}],
    "sweep": [{"name": "last", "sweep": {"over": {"wall": [0.15, 0.3, 24]}, **SETTLING}}],
    "basin": [{"name": "last", "basin": {"over": {"x": [-1, 0.1, 3], "v": [-1, 1, 8]}, **SETTLING}}],
    "precision": [*START, {"name": "last", "precision": PRECISION}],
}
# Columns that a clock or the machine fills: no two runs have the same.
MEASURED = tuple(f"/points/{name}" for name in ("wall", "wall_low", "wall_high", "cpu", "memory"))


def run_of(kind):
    """Return a run, within its model, whose last step, ``last``, is of a kind."""
    return change(MODEL, "run.steps", KINDS[kind])


def text_of(kind):
    """Return that run as the text of its file."""
    return to_yaml(run_of(kind))


def plan_of(kind):
    """Return the plan of that run."""
    return load_run_plan(parse_document(text_of(kind), "quick.yaml"))


def contents(path):
    """Return everything that a results file holds, name by name, in its order, but for what is measured."""
    found = {}

    def visit(name, item):
        found[name + "@"] = dict(item.attrs)
        if isinstance(item, h5py.Dataset) and not name.endswith(MEASURED):
            found[name] = (
                item.dtype.str,
                item.shape,
                item.asstr()[()] if item.dtype.kind == "O" else item[()].tobytes(),
            )

    with h5py.File(path, "r") as file:
        found["/"] = (dict(file.attrs), list(file["steps"]))
        file.visititems(visit)
    return found


def is_beginning(step, whole):
    """Whether all that a step holds is what the uninterrupted run's step begins with, bit for bit."""
    n = len(step)
    if n > len(whole) or step.meta != whole.meta or step.kind != whole.kind:
        return False
    points = all(
        np.array_equal(rows.view(np.uint8).ravel(), np.ascontiguousarray(whole.points[key][:n]).view(np.uint8).ravel())
        for key, rows in ((k, np.ascontiguousarray(v)) for k, v in step.points.items())
        if n and not f"/points/{key}".endswith(MEASURED)
    )
    return points and all(
        a.tobytes() == whole.orbit(i)[key].tobytes() for i in range(n) for key, a in step.orbit(i).items()
    )


@contextlib.contextmanager
def start_run(folder, *words, on_ctrl_c=signal.SIG_DFL):
    """Start ``pddecont run`` with some words more and yield the process when it computes; it does not outlive this.

    Ctrl-C reaches it whatever started the tests: a job in the background leaves the signal out, and so would what it
    starts.
    """
    with subprocess.Popen(
        [sys.executable, "-m", "pddecont", "run", *map(str, words)],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: signal.signal(signal.SIGINT, on_ctrl_c),
    ) as process:
        try:
            line = process.stderr.readline()
            assert "..." in line, line
            yield process
        finally:
            process.kill()
