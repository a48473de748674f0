"""Random orbits solved for random accuracies, and how far they are from far finer ones.

Run as a module it measures a number of them: ``python -m tests.accuracy_samples NUMBER SEED``.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pddecont.collocation import MeshRule
from pddecont.errors import ConvergenceError, SignatureError
from pddecont.orbit import adapt_mesh, estimate_error, solve_orbit
from pddecont.simulate import Workers
from pddecont.steps import Context, Silent
from pddecont.steps.execution.accuracy import choose_settings, measure_distance
from pddecont.steps.execution.orbit import make_guess
from tests.known_orbits import HARD_WALL
from tests.runs import plan

RELAY = {
    "name": "relay_with_two_delays",
    "states": ["x", "v"],
    "parameters": {"z": 0.4, "tau": 2.3, "tau2": 0.35, "K": -0.2, "th": 0.05, "low": -0.8},
    "modes": {
        "A": {"x'": "v", "v'": "-x - 2*z*v + 1 + K*v(t - tau2)"},
        "B": {"x'": "v", "v'": "-x - 2*z*v + low + K*v(t - tau2)"},
    },
    "events": {"s": "x(t - tau) - th"},
    "segments": {
        "a": {"mode": "A", "event": "s", "direction": "rising", "to": "B"},
        "b": {"mode": "B", "event": "s", "direction": "falling", "to": "A"},
    },
    "initial": {"mode": "A", "x": -0.05, "v": 0.3},
}
SOFT_WALL = {
    "name": "soft_wall_with_delay",
    "states": ["x", "v"],
    "parameters": {"omega": 1.2, "c": 0.2, "wall": 0.5, "k": 8, "K": 0.1, "tau": 0.7},
    "forcing": {"period": "2*pi/omega"},
    "definitions": {"force": "cos(omega*t) - c*v - x + K*x(t - tau)"},
    "modes": {"free": {"x'": "v", "v'": "force"}, "touch": {"x'": "v", "v'": "force - k*(x - wall)"}},
    "events": {"hit": "x - wall"},
    "segments": {
        "F": {"mode": "free", "event": "hit", "direction": "rising", "to": "touch"},
        "T": {"mode": "touch", "event": "hit", "direction": "falling", "to": "free"},
    },
}
SPIKING = {
    "name": "fire_with_delay",
    "states": ["v"],
    "parameters": {"I": 1.6, "K": 0.3, "tau": 0.8},
    "modes": {"rest": {"v'": "I - v + K*sin(3*v(t - tau))"}},
    "events": {"fire": "v - 1"},
    "resets": {"zero": {"v": 0}},
    "segments": {"up": {"mode": "rest", "event": "fire", "direction": "rising", "reset": "zero", "to": "rest"}},
}
# Models with the time after which their motions have settled, and the ranges that parameters are drawn from.
FAMILIES = (
    (RELAY, 400.0, {"z": (0.2, 0.8), "tau": (0.5, 3), "tau2": (0.1, 2), "K": (-0.3, 0.3), "low": (-1.2, -0.6)}),
    (HARD_WALL, 500.0, {"omega": (1.6, 2.6), "c": (0.1, 0.4), "wall": (0, 0.3), "r": (0.5, 0.8), "tau": (0.3, 3)}),
    (SOFT_WALL, 500.0, {"omega": (0.8, 1.6), "c": (0.15, 0.5), "wall": (0.2, 0.8), "k": (2, 20), "tau": (0.3, 3)}),
    (SPIKING, 200.0, {"I": (1.4, 3), "K": (-0.3, 0.3), "tau": (0.2, 1.5)}),
)
# How much finer references are, and orders of magnitude that accuracies are drawn from.
FINER, EXPONENTS = 1e-3, (-10.0, -3.0)
# Longer signatures are of motions that have hardly settled.
MAX_SEGMENTS = 8


@dataclass(frozen=True)
class Sample:
    """One orbit: its model, the accuracy asked for, the row's own estimate, and the true error."""

    model: str
    accuracy: float
    estimate: float
    error: float

    @property
    def ratio(self) -> float:
        """The error as a multiple of the accuracy."""
        return self.error / self.accuracy


def measure_samples(number: int, seed: int) -> tuple[list[Sample], int]:
    """Return so many samples, and how often no accuracy was promised, as no mesh reaches it."""
    rng, found, refused = np.random.default_rng(seed), [], 0
    while len(found) < number:
        model, t_end, ranges = FAMILIES[int(rng.integers(len(FAMILIES)))]
        values = {name: float(rng.uniform(*ends)) for name, ends in ranges.items()}
        accuracy = float(10.0 ** rng.uniform(*EXPONENTS))
        steps = [
            {"name": "t", "simulate": {"t_end": t_end, "rtol": 1e-11, "atol": 1e-13}},
            {"name": "o", "orbit": {"from": "t"}},
        ]
        checked = plan({**model, "run": {"set": values, "accuracy": accuracy, "steps": steps}})
        context, step = Context(checked, Path("none.h5"), Silent(), Workers()), checked.steps[1]
        try:
            guess = make_guess(context, replace(step, rule=MeshRule(8, None, 1e-6)))
            if len(guess.signature) > MAX_SEGMENTS:
                continue
            fine = solve_orbit(guess, MeshRule(8, None, 1e-6)).at.orbit
        except (ConvergenceError, SignatureError):
            continue
        try:
            chosen = choose_settings(context, step, None)
        except ConvergenceError:
            refused += 1
            continue
        orbit = solve_orbit(make_guess(context, chosen), chosen.rule).at.orbit
        error = measure_true_error(orbit, fine, accuracy)
        found.append(Sample(model["name"], accuracy, estimate_error(orbit), error))
    return found, refused


def measure_true_error(orbit, fine, accuracy):
    """Return how far an orbit is from one that is solved for by polynomials of degree 13 and far smaller tolerance."""
    rule = MeshRule(13, None, max(FINER * accuracy, 1e-13))
    return measure_distance(orbit, solve_orbit(adapt_mesh(fine, rule), rule).at.orbit)


def main(number, seed):
    samples, refused = measure_samples(int(number), int(seed))
    ratios = np.array([sample.ratio for sample in samples])
    for sample in sorted(samples, key=lambda s: -s.ratio)[:8]:
        print(sample, f"{sample.ratio:.2f}")
    kept = np.mean(ratios <= 1.0)
    print(f"{len(samples)} orbits, {kept:.1%} within, worst {ratios.max():.2f}, refused {refused}")


if __name__ == "__main__":
    main(*sys.argv[1:])
