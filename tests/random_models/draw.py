"""Random numbers for models, and the parts that several families share."""

from __future__ import annotations

import numpy as np

from tests.random_models.formula import States, call, name


class Draw:
    """Random numbers of a few digits, so that a model's text is the model."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)

    def between(self, low, high):
        """Return a number in a range."""
        return round(float(self.rng.uniform(low, high)), 4)

    def signed(self, low, high):
        """Return a number whose modulus lies in a range."""
        return self.between(low, high) * self.one_of([-1, 1])

    def one_of(self, values):
        """Return one of several values."""
        return values[int(self.rng.integers(len(values)))]

    def chance(self, p):
        """Return true with probability ``p``."""
        return bool(self.rng.random() < p)

    def lags(self, low=0.15, high=3.0):
        """Return one to three delays by name."""
        return {f"tau{i + 1}": self.between(low, high) for i in range(self.one_of([1, 1, 2, 3]))}

    def span(self, value, width=0.6):
        """Return a range around a parameter's value."""
        lower, upper = value * (1 - self.between(0.5, 1) * width), value * (1 + self.between(0.5, 1) * width)
        return (round(min(lower, upper), 4), round(max(lower, upper), 4))


def feedback(draw, states, delays, parameters, low=0.02, high=0.15):
    """Return a sum of delayed states, one for each delay, with gains that become parameters."""
    total = None
    for i, delay in enumerate(delays):
        gain = f"K{i + 1}"
        parameters[gain] = draw.signed(low, high)
        state = states[draw.one_of(list(states.names)), delay]
        term = name(gain) * (call("tanh", 2 * state) if draw.chance(0.2) else state)
        total = term if total is None else total + term
    return total


def driven(draw):
    """Return what driven oscillators share: states, parameters, delays, force without contact."""
    states, delays = States(("x", "v")), draw.lags()
    parameters = {"omega": draw.between(0.7, 2.2), "A": draw.between(0.6, 1.4), "c": draw.between(0.1, 0.5), **delays}
    force = name("A") * call("cos", name("omega") * name("t")) - name("c") * states["v"] - states["x"]
    if draw.chance(0.3):
        parameters["a3"] = draw.between(0.1, 0.6)
        force = force - name("a3") * states["x"] ** 3
    force = force + feedback(draw, states, delays, parameters)
    return states, parameters, delays, force, (2 * name("pi")) / name("omega")
