"""Ratios, each measured in one process: ``make bench``."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import math
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.timing import peak, timed
from pddecont.codegen import NumericModel
from pddecont.collocation import MeshRule
from pddecont.continuation import factor
from pddecont.delay import Chain, Chebyshev, Direct
from pddecont.model import load_model
from pddecont.orbit import Orbit, PeriodicOrbitSystem, adapt_mesh, guess_from_cycle, measure_orbit, solve_orbit
from pddecont.simulate import detect_period, simulate
from pddecont.stability import find_multipliers

ROOT = Path(__file__).parent.parent


def impact_orbit():
    """Return the impact oscillator's orbit."""
    numeric = NumericModel(load_model(str(ROOT / "models" / "impact_oscillator.yaml"))[0])
    p = numeric.parameter_values
    cycle = detect_period(numeric, p, simulate(numeric, p, Direct(), 50 * 2 * math.pi / 0.8))
    rule = MeshRule(6, intervals=40)
    return solve_orbit(guess_from_cycle(numeric, p, Direct(), cycle, rule), rule).at.orbit


def with_delay(orbit, method):
    """Return the orbit as a guess with its delay read by another method."""
    return adapt_mesh(Orbit(replace(orbit.problem, delay=method), orbit.x), MeshRule(6, intervals=40))


def newton_step(orbit):
    """Return what one Newton step costs: a function that evaluates, factors and solves."""
    orbit = orbit.with_free(("tau_d",))
    system = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, (1.0,)))

    def step():
        at = system.at(orbit.x.copy())
        factor(at.jacobian()[:, :-1])(-at.residual)

    return step


def main():
    """Print the tables."""
    orbit = impact_orbit()
    methods = {
        "chain n = 15": Chain(2, 15),
        "chain n = 100": Chain(2, 100),
        "chain n = 1000": Chain(2, 1000),
        "chain n = 10000": Chain(2, 10000),
        "chebyshev n = 20": Chebyshev(20),
        "direct": Direct(),
    }
    steps = {}
    for name, method in methods.items():
        steps[name] = newton_step(with_delay(orbit, method))
    times = timed(steps)
    memory = {name: peak(f) for name, f in steps.items()}
    unknowns = len(orbit.x)
    print(f"Newton step of the impact oscillator with tau_d free, 40 intervals of degree 6, {unknowns} unknowns")
    print(f"{'delay':18} {'time / chain 15':>16} {'memory / chain 15':>18} {'ms':>8}")
    for name in methods:
        ratios = times[name] / times["chain n = 15"], memory[name] / memory["chain n = 15"]
        print(f"{name:18} {ratios[0]:16.2f} {ratios[1]:18.2f} {1e3 * times[name]:8.1f}")
    assert np.isfinite(list(times.values())).all()
    print()
    stability(orbit)


def stability(orbit):
    """Print what the leading multipliers cost beside a Newton step of the same orbit."""
    print("Multipliers of the same orbit against a Newton step of it")
    print(f"{'delay':18} {'multipliers / step':>18} {'ms':>8}")
    methods = {
        "direct": Direct(),
        "chain n = 15": Chain(2, 15),
        "chain n = 100": Chain(2, 100),
        "chebyshev n = 20": Chebyshev(20),
    }
    for name, method in methods.items():
        other = with_delay(orbit, method)
        times = timed({"step": newton_step(other), "multipliers": partial(find_multipliers, other)}, 5)
        print(f"{name:18} {times['multipliers'] / times['step']:18.2f} {1e3 * times['multipliers']:8.1f}")


if __name__ == "__main__":
    main()
