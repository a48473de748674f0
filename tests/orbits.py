"""Orbits of models, and how fast simulated motions return to them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pddecont.collocation import Piece
from pddecont.orbit import solve_orbit
from pddecont.simulate import Method, Workers, simulate
from pddecont.steps import Context, Silent
from pddecont.steps.execution.orbit import make_guess
from tests.runs import plan

FINE = {"degree": 10, "tol": 1e-11}


def settle_to_orbit(model, changes=None, t_end=60, *, mesh=FINE, delay=None, initial=None, atol=None):
    """Return the orbit that a model (a shipped one's name, or a mapping) settles to in a time."""
    steps = [
        {"name": "t", "simulate": {"t_end": t_end, "initial": initial or {}, **({"atol": atol} if atol else {})}},
        {"name": "o", "orbit": {"from": "t"}},
    ]
    keys = {"set": changes or {}, "mesh": mesh, "delay": delay or {"method": "direct"}, "steps": steps}
    checked = plan({**model, "run": keys} if isinstance(model, dict) else {"model": model, **keys})
    context = Context(checked, Path("none.h5"), Silent(), Workers())
    step = checked.steps[1]
    return solve_orbit(make_guess(context, step), step.rule).at.orbit


def segment_pieces(n_segments, n_theta, cuts):
    """Return one piece a segment, cut at the fractions in ``cuts``."""
    ends = np.zeros((n_segments + 1, n_theta))
    for s in range(n_segments):
        ends[s + 1, : s + 1] = 1.0
    return tuple(Piece(s, ends[s], ends[s + 1], np.asarray(c)) for s, c in enumerate(cuts))


def measure_decay(orbit, n_periods):
    """Return the leading multipliers that a simulated motion shows on its way to the orbit.

    Its distances d_k from where it ends, one period apart, obey d_{k+1} = r d_k, or where two multipliers show d_{k+2}
    = s d_{k+1} - p d_k.
    """
    period, problem = orbit.period, orbit.problem
    trajectory = simulate(
        orbit.numeric, problem.parameters, problem.delay, (n_periods + 0.4) * period, Method(1e-11, 1e-13)
    )
    z = np.array([trajectory((k + 0.37) * period) for k in range(n_periods)])
    d = z - z[-1]
    size = np.max(np.abs(d), axis=1)
    first = int(np.flatnonzero(size > 1e-3)[-1]) + 1
    last = int(np.flatnonzero(size > 1e-7)[-1]) + 1
    assert last - first > 4, "too few periods between far and near"
    window = d[first:last]
    ratio = np.vdot(window[:-1], window[1:]) / np.vdot(window[:-1], window[:-1])
    if np.linalg.norm(window[1:] - ratio * window[:-1]) < 1e-3 * np.linalg.norm(window[1:]):
        return [complex(ratio)]
    rows = np.stack([window[1:-1].ravel(), -window[:-2].ravel()], axis=1)
    s, p = np.linalg.lstsq(rows, window[2:].ravel(), rcond=None)[0]
    return sorted(np.roots([1.0, -s, p]), key=abs, reverse=True)
