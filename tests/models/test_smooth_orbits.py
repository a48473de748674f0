"""Models that read rates and integrals of the past against Fourier collocation and the method of steps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import roots_genlaguerre

from pddecont.collocation import MeshRule
from pddecont.delay import Direct
from pddecont.orbit import guess_from_cycle, solve_orbit
from tests.conftest import shipped
from tests.delay_kinds import Known
from tests.models import smooth_orbits
from tests.models.expected import entry, evaluated
from tests.models.method_of_steps import Motion
from tests.models.smooth_orbits import find_extrema, find_orbit

TURN = 2 * math.pi


def values(model, what):
    item = entry(model, what)
    return np.array(evaluated(item["value"], {})), item["tol"]


def sine(t, period, phase=0.0):
    return np.cos(TURN * (t / period + phase))


def wave(t, period=8.885):
    speeds = [1 + 0.9 * sine(t, period, k / 3) for k in range(3)]
    return np.array([*speeds, *(3 + 2.3 * sine(t, period, k / 3 + 5 / 12) for k in range(2))])


# Each model's equation, a rough guess with its period, harmonics, parameters that differ from the file's, its mode, and
# the entry with which of the states' extrema it lists.
ORBITS = {
    "transmission_line": (
        smooth_orbits.line, lambda t: 1.6 * sine(t, 12.15)[None], 12.15, 40, {"tau": 4.0}, "line",
        ("period and maximum at tau = 4", [(0, 1)]),
    ),
    "neutral_logistic": (
        smooth_orbits.logistic, lambda t: np.exp(-1.1 + 2.4 * sine(t, 11.39))[None], 11.39, 60, {"tau": 2.5}, "food",
        ("period, maximum and minimum at tau = 2.5", [(0, 1), (0, 0)]),
    ),
    "distributed_maturation": (
        smooth_orbits.blowflies, lambda t: 3 + 3 * sine(t, 7.63)[None], 7.63, 40, {"tau": 3.0}, "adults",
        ("period, maximum and minimum at tau = 3", [(0, 1), (0, 0)]),
    ),
    "remembering_drivers": (
        smooth_orbits.drivers, wave, 8.885, 40, {"tau": 0.8}, "ring",
        ("period, fastest and nearest at tau = 0.8", [(0, 1), (3, 0)]),
    ),
}  # fmt: skip


def measure_error(orbit, known, n_states):
    """Return the largest error of an orbit's base values, its phase fitted."""
    times, shift = orbit.mesh.base_times(orbit.theta), 0.0
    for _ in range(6):
        rate = known(times + shift, 1)[0]
        shift += float(rate @ (orbit.values[:, 0] - known(times + shift)[0]) / (rate @ rate))
    return float(np.max(np.abs(orbit.values[:, :n_states] - known(times + shift).T)))


class Cycle(Known):
    """A Fourier orbit as a cycle of a model, with the memories that the model keeps besides."""

    def __init__(self, orbit, mode, remember):
        super().__init__(orbit)
        self.mode, self.remember = mode, remember

    def evaluate(self, segment, t):
        return np.concatenate([self.orbit(t), self.remember(self.orbit, np.asarray(t))]).T


def remember(orbit, t, k=0.8, h=3.0, tau=0.8, theta=0.1):
    """Return the drivers' memories: means over exponential and gamma kernels, in the order of the model's states."""
    means = []
    for power in (0, 1):
        lags, weights = roots_genlaguerre(40, power)
        late = orbit(t[..., None] - tau - theta * lags)
        gaps = [late[3], late[4], 3 * h - late[3] - late[4]]
        means.append([np.tanh(k * (gap - h)) @ weights for gap in gaps])
    return np.array([means[power][car] for car in range(3) for power in range(2)])


@pytest.mark.parametrize("name", ORBITS)
def test_orbits_against_fourier_collocation(name):
    field, guess, period, n, given, mode, (what, extrema) = ORBITS[name]
    known = find_orbit(field, guess, period, n)
    found = find_extrema(known)
    expected, tol = values(name, what)
    assert [found.period, *(found.of[state][side] for state, side in extrema)] == pytest.approx(expected, abs=tol / 10)
    numeric = shipped(name)
    p = np.array([given.get(k, v) for k, v in numeric.model.parameters.items()], dtype=float)
    rule = MeshRule(7, None, 1e-12)
    nothing = lambda orbit, t: np.empty((0, *t.shape))  # noqa: E731
    cycle = Cycle(known, mode, remember if name == "remembering_drivers" else nothing)
    guessed = guess_from_cycle(numeric, p, Direct(), cycle, rule)
    orbit = solve_orbit(guessed.with_phase_reference(), rule).at.orbit
    assert abs(orbit.period - known.period) < 1e-10
    assert measure_error(orbit, known, len(known.coefficients)) < 1e-10


def touching_sway(tau):
    """Return the sway of the arm without stops at a delay, from a rough guess."""
    field = lambda t, x, read: smooth_orbits.arm(t, x, read, tau=tau)  # noqa: E731
    guess = lambda t: 0.5 * np.array([sine(t, 6.2), sine(t, 6.2, 0.25)])  # noqa: E731
    return find_orbit(field, guess, 6.2, 20)


def test_the_arm_first_touches_its_stops_where_fourier_collocation_says():
    tau = brentq(lambda tau: find_extrema(touching_sway(tau)).of[0][1] - 0.5, 0.852, 0.855, xtol=1e-12)
    expected, tol = values("robot_arm", "period of the sway that just touches the stops")
    assert [tau, touching_sway(tau).period] == pytest.approx(expected, abs=tol / 10)


def test_the_arm_strikes_as_by_the_method_of_steps():
    """The rate a delay ago is what the equation says there: a sum over all delays before, each with a factor -A more.

    What is left of the transient falls by a multiplier of .114 a period.
    """
    P, D, A, tau, wall, r, n = 1.5, 1.5, 0.2, 0.9, 0.5, 0.2, 20

    def field(t, z, past):
        known = [z, *(past(k * tau) for k in range(1, n + 1))]
        rate = 0.0
        for k in reversed(range(n)):
            # Before the start the arm was held.
            now, late = known[k], known[k + 1]
            rate = 0.0 if t < k * tau else math.sin(now[0]) - P * late[0] - D * late[1] - A * rate
        return [z[1], rate]

    exits = [
        (lambda t, z, past: z[0] - wall, 1, lambda t, z, past: np.array([z[0], -r * z[1]]), "arm", "rises"),
        (lambda t, z, past: z[0] + wall, -1, lambda t, z, past: np.array([z[0], -r * z[1]]), "arm", "falls"),
    ]
    delays = tuple(k * tau for k in range(1, n + 1))
    held = lambda t: np.array([0.3, 0.0])  # noqa: E731
    motion = Motion({"arm": field}, {"arm": exits}, delays, held, "arm", echoes=1, start=np.array([0.3, 0.9]))
    strikes = motion.run(55.0).times("rises")
    expected, tol = values("robot_arm", "period of the strikes")
    assert strikes[-1] - strikes[-2] == pytest.approx(strikes[-2] - strikes[-3], abs=tol / 10)
    assert strikes[-1] - strikes[-2] == pytest.approx(float(expected), abs=tol / 10)
