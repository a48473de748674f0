"""Ratios, each measured in one process: ``make bench``."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import math
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.timing import peak, timed
from pddecont.continuation.linear import factor
from pddecont.delay.chain import Chain
from pddecont.delay.chebyshev import Chebyshev
from pddecont.delay.direct import Direct
from pddecont.model.builder import load_model
from pddecont.model.codegen import NumericModel
from pddecont.orbit.curve import Curve, settle, sizes_of
from pddecont.orbit.guess import orbit_from_cycle
from pddecont.orbit.meshing import MeshRule, remeshed
from pddecont.simulate.integrate import simulate
from pddecont.simulate.recognise import recognise
from pddecont.stability.multipliers import multipliers

ROOT = Path(__file__).parent.parent


def impact_orbit():
    """Return the impact oscillator's orbit as problem and unknowns."""
    numeric = NumericModel(load_model(str(ROOT / "models" / "impact_oscillator.yaml"))[0])
    p = numeric.parameter_values
    cycle = recognise(numeric, p, simulate(numeric, p, Direct(), 50 * 2 * math.pi / 0.8))
    rule = MeshRule(6, intervals=40)
    problem, guess = orbit_from_cycle(numeric, p, Direct(), cycle, rule)
    problem, solution = settle(problem, guess, rule)
    return problem, solution.x


def newton_step(problem, x):
    """Return what one Newton step costs: a function that evaluates, factors and solves."""
    problem, x = problem.with_free(x, ("tau_d",))
    curve = Curve(problem, sizes_of(problem, x, (1.0,)))

    def step():
        y = x.copy()
        r = curve.residual(y)
        matrix = curve.jacobian(y)
        square = matrix[:, :-1]
        factor(square).solve(-r)

    return step


def main():
    """Print the tables."""
    from dataclasses import replace

    problem, x = impact_orbit()
    methods = {"chain n = 15": Chain(2, 15), "chain n = 100": Chain(2, 100), "chain n = 1000": Chain(2, 1000),
               "chain n = 10000": Chain(2, 10000), "chebyshev n = 20": Chebyshev(20), "direct": Direct()}  # fmt: skip
    steps = {}
    for name, method in methods.items():
        other, guess = remeshed(replace(problem, delay=method), x, MeshRule(6, intervals=40))
        steps[name] = newton_step(other, guess)
    times = timed(steps)
    memory = {name: peak(f) for name, f in steps.items()}
    unknowns = len(x)
    print(f"Newton step of the impact oscillator with tau_d free, 40 intervals of degree 6, {unknowns} unknowns")
    print(f"{'delay':18} {'time / chain 15':>16} {'memory / chain 15':>18} {'ms':>8}")
    for name in methods:
        ratios = times[name] / times["chain n = 15"], memory[name] / memory["chain n = 15"]
        print(f"{name:18} {ratios[0]:16.2f} {ratios[1]:18.2f} {1e3 * times[name]:8.1f}")
    assert np.isfinite(list(times.values())).all()
    print()
    stability(problem, x)


def stability(problem, x):
    """Print what the leading multipliers cost beside a Newton step of the same orbit."""
    from dataclasses import replace

    print("Multipliers of the same orbit against a Newton step of it")
    print(f"{'delay':18} {'multipliers / step':>18} {'ms':>8}")
    methods = {"direct": Direct(), "chain n = 15": Chain(2, 15), "chain n = 100": Chain(2, 100), "chebyshev n = 20": Chebyshev(20)}
    for name, method in methods.items():
        other, guess = remeshed(replace(problem, delay=method), x, MeshRule(6, intervals=40))
        times = timed({"step": newton_step(other, guess), "multipliers": partial(multipliers, other, guess)}, 5)
        print(f"{name:18} {times['multipliers'] / times['step']:18.2f} {1e3 * times['multipliers']:8.1f}")


if __name__ == "__main__":
    main()
