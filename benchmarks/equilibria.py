"""What an equilibrium with its roots costs, over the number of states, and what a curve of Hopf points: part of ``make
bench``.

The model is a chain of masses, each damped late: roots of so many pairs of states lie beside one another.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from pddecont.codegen import NumericModel
from pddecont.delay import Direct
from pddecont.equilibrium import ConstantMotion, Equilibrium, find_own_roots, solve_equilibrium
from pddecont.model import parse_document, parse_model
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute

REPEATS = 5
CURVE = """\
model: MODEL
steps:
  - {name: rest, equilibrium: {from: {x1: 0}}}
  - {name: at_rest, continue: {from: rest, free: [tau], range: {tau: [0.5, 3]}}}
  - name: hopf
    continue:
      from: {step: at_rest, point: HB1}
      free: [tau, K]
      range: {tau: [0.5, 12], K: [0, 2]}
      direction: up
      max_points: 100
      step: {initial: 0.01, max: 0.02}
"""


def chain_text(n_masses: int) -> str:
    """Return the model of a chain of masses between two walls."""
    names = range(1, n_masses + 1)
    inside = {0: "0", n_masses + 1: "0"} | {i: f"x{i}" for i in names}
    lines = [
        f"  x{i}': v{i}\n"
        f"  v{i}': -c*v{i} - x{i} - K*tanh(v{i}(t - tau)) + e*({inside[i - 1]} - 2*x{i} + {inside[i + 1]})\n"
        for i in names
    ]
    states = ", ".join(f"x{i}, v{i}" for i in names)
    return (
        f"name: late_chain\nstates: [{states}]\nparameters: {{c: 0.05, e: 0.1, K: 0.3, tau: 1}}\n"
        f"equations:\n{''.join(lines)}"
    )


def points() -> None:
    """Print what one equilibrium costs: Newton's method, and the roots with their count."""
    print("An equilibrium of a chain of masses with delayed damping, and its roots; CPU time, the least of several")
    print(f"  {'states':>6} {'tau':>4} {'Newton':>10} {'roots':>10} {'found':>6} {'unstable':>9} {'residual':>9}")
    for n_masses in (1, 10, 100):
        numeric = NumericModel(parse_model(parse_document(chain_text(n_masses), "chain.yaml"))[0])
        motion = ConstantMotion(numeric, next(iter(numeric.model.modes)), Direct())
        for tau in (1.0, 3.0):
            p = numeric.parameter_values.copy()
            p[-1] = tau
            guess = Equilibrium(motion, np.full(2 * n_masses, 1e-2), p)
            at = solve_equilibrium(guess)[0]
            newton = least(partial(solve_equilibrium, guess))
            seconds = least(partial(find_own_roots, motion, at.states, at.parameters))
            roots = find_own_roots(motion, at.states, at.parameters)
            counted = str(roots.n_unstable) if roots.counted else "?"
            print(
                f"  {2 * n_masses:6} {tau:4.0f} {1e3 * newton:7.1f} ms {1e3 * seconds:7.1f} ms {len(roots.values):6} "
                f"{counted:>9} {np.max(roots.residuals):9.0e}"
            )
    print()


def curves() -> None:
    """Print what curves of Hopf points cost, with their special points, roots and coefficients."""
    print("A curve of Hopf points of the same chain; CPU time of the whole step")
    for n_masses in (1, 10):
        with tempfile.TemporaryDirectory() as folder:
            model, path = Path(folder) / "chain.yaml", Path(folder) / "chain.h5"
            model.write_text(chain_text(n_masses))
            plan = load_run_plan(parse_document(CURVE.replace("MODEL", str(model)), str(Path(folder) / "run.yaml")))
            execute(plan, path, until="at_rest")
            start = time.process_time()
            execute(plan, path, resume=True)
            seconds = time.process_time() - start
            n_points = len(read_results(path).step("hopf"))
            print(
                f"  {2 * n_masses:6} states {n_points:4} points {seconds:6.2f} s, "
                f"{1e3 * seconds / n_points:6.1f} ms each"
            )
    print()


def least(call: Callable[[], object]) -> float:
    """Return the least CPU time of some calls."""
    call()
    found = []
    for _ in range(REPEATS):
        start = time.process_time()
        call()
        found.append(time.process_time() - start)
    return min(found)


def main() -> None:
    """Print the tables."""
    points()
    curves()


if __name__ == "__main__":
    main()
