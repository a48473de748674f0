"""Smooth orbits with delays that vary, rates and integrals of the past, by Fourier collocation and as first guesses."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from pddecont.delay import Direct
from pddecont.orbit import guess_from_cycle, solve_orbit
from tests.conftest import numeric_from
from tests.fourier import find_fourier_orbit
from tests.runs import to_yaml

W = 2.0
XI, OMEGA = np.polynomial.legendre.leggauss(40)
XI, OMEGA = 0.5 * (XI + 1), 0.5 * OMEGA


def state_dependent(t, x, read):
    return -2.0 * np.tanh(read(t - 1 - 0.3 * x[0]))


def nested(t, x, read):
    return -2.0 * np.tanh(read(t - 1 - 0.2 * read(t - 0.5 - 0.1 * x[0])[0]))


def varying_in_time(t, x, read):
    return -x - np.tanh(read(t - 1 - 0.3 * np.cos(W * t))) + np.cos(W * t)


def neutral(t, x, read):
    return -x + 0.4 * read(t - 1, 1) - np.tanh(read(t - 1)) + np.cos(W * t) + 0.2 * read(t - 0.5 - 0.2 * x[0], 1)


def distributed(t, x, read):
    lags, high = 0.3 + 0.8 * XI, 1.5 + 0.3 * x[0]
    first = 0.8 * (np.exp(-0.5 * lags) * np.tanh(read(t[:, None] - lags))) @ OMEGA
    second = high * (read(t[:, None] - high[:, None] * XI) ** 2 @ OMEGA)
    return -x - first + np.cos(W * t) - 0.7 * second


# What each model's equation says, and the same in numbers; whether it is forced.
KINDS = {
    "state-dependent": ("-2*tanh(x(t - 1 - c*x))", {"c": 0.3}, state_dependent, False),
    "nested": ("-2*tanh(x(t - 1 - c*x(t - 0.5 - 0.1*x)))", {"c": 0.2}, nested, False),
    "varying in time": ("-x - tanh(x(t - 1 - c*cos(w*t))) + cos(w*t)", {"c": 0.3}, varying_in_time, True),
    "neutral": ("-x + c*x'(t - 1) - tanh(x(t - 1)) + cos(w*t) + 0.2*x'(t - 0.5 - 0.2*x)", {"c": 0.4}, neutral, True),
    "distributed": (
        "-x - integral(exp(-c*s)*tanh(x(t - s)), s, a, a + 0.8) + cos(w*t)"
        " - 0.7*integral(x(t - s)**2, s, 0, 1.5 + 0.3*x)",
        {"c": 0.5, "a": 0.3},
        distributed,
        True,
    ),
}


def numeric_of(kind):
    law, parameters, _, forced = KINDS[kind]
    model = {"name": "m", "states": ["x"], "parameters": parameters, "modes": {"m": {"x'": law}}}
    if forced:
        model |= {"parameters": {**parameters, "w": W}, "forcing": {"period": "2*pi/w"}}
    return numeric_from(to_yaml(model))


@cache
def exact(kind):
    """Return the orbit by Fourier collocation, from a coarse one on."""
    _, _, field, forced = KINDS[kind]
    period = 2 * math.pi / W if forced else 4.2
    guess = lambda t: (1.0 if forced else 1.1) * np.cos(2 * math.pi / period * t)[None]  # noqa: E731
    found = find_fourier_orbit(field, guess, period, 12, free_period=not forced)
    found = find_fourier_orbit(field, found, found.period, 40, free_period=not forced)
    assert found.residual < 1e-11
    assert np.max(np.abs(found.coefficients[:, 0])) < 1e-11
    assert np.ptp(found(np.linspace(0, found.period, 99))) > 0.5
    return found


class Known:
    """A Fourier orbit as a cycle to begin from."""

    def __init__(self, orbit):
        self.orbit, self.signature, self.n_periods, self.mode = orbit, (), 1, "m"
        self.times = np.array([0.0, orbit.period])

    def evaluate(self, segment, t):
        return self.orbit(t).T


def solve(kind, rule):
    numeric = numeric_of(kind)
    guess = guess_from_cycle(numeric, numeric.parameter_values, Direct(), Known(exact(kind)), rule)
    return solve_orbit(guess.with_phase_reference(), rule).at.orbit
