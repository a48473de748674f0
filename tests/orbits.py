"""Orbits of shipped models as problems and unknowns, and how fast simulated motions return to them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pddecont.model.document import parse_document
from pddecont.orbit.curve import settle
from pddecont.simulate.integrate import simulate
from pddecont.simulate.simulator import Method
from pddecont.steps.context import Context, Silent
from pddecont.steps.loading import load_plan
from pddecont.steps.orbit import first_guess
from tests.conftest import ROOT


def orbit(model, changes="", t_end=60, *, mesh="degree: 10, tol: 1e-11", delay="method: direct", initial=""):
    """Return problem and unknowns of the orbit that a model settles to."""
    start = f", initial: {{{initial}}}" if initial else ""
    text = (f"model: {model}\nset: {{{changes}}}\nmesh: {{{mesh}}}\ndelay: {{{delay}}}\nsteps:\n"
            f"  - {{name: t, simulate: {{t_end: {t_end}{start}}}}}\n  - {{name: o, orbit: {{from: t}}}}\n")  # fmt: skip
    context = Context(load_plan(parse_document(text, str(ROOT / "configs" / "test.yaml"))), Path("none.h5"), Silent())
    step = context.plan.run.steps[1]
    problem, solution = settle(*first_guess(context, step), context.rule_of(step))
    return problem, solution.x


def decay(problem, x, n_periods):
    """Return the leading multipliers that a simulated motion shows on its way to the orbit.

    Its distances d_k from where it ends, one period apart, obey d_{k+1} = r d_k, or where two multipliers show d_{k+2} = s d_{k+1} - p d_k.
    """
    period = problem.period(x)
    trajectory = simulate(problem.numeric, problem.parameters, problem.delay, (n_periods + 0.4) * period, Method(1e-11, 1e-13))
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
