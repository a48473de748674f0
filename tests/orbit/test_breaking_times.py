"""Breaking times of delays that vary: among the unknowns, tracked, and exact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.optimize

from pddecont.collocation import MeshRule
from pddecont.delay import Direct
from pddecont.orbit import Orbit, guess_from_cycle, solve_orbit
from pddecont.orbit.preimages import PreimageSearch
from pddecont.orbit.serialise import mesh_from_row, mesh_to_row
from pddecont.orbit.system import PeriodicOrbitSystem, measure_orbit
from pddecont.stability import find_multipliers
from tests.conftest import numeric_from
from tests.orbits import settle_to_orbit
from tests.runs import to_yaml

# A clock that counts to one, and what follows it by a lag that depends on itself: y' = -y + frac(t - 1/2 - c y).
CLOCK = {
    "name": "clock",
    "states": ["x", "y"],
    "parameters": {"c": 0.25},
    "modes": {"m": {"x'": "1", "y'": "-y + x(t - 0.5 - c*y)"}},
    "events": {"full": "x - 1"},
    "resets": {"empty": {"x": "0"}},
    "segments": {"tick": {"mode": "m", "event": "full", "direction": "rising", "reset": "empty", "to": "m"}},
}
# A switch with a jump, whose state is read by a lag that depends on it.
RELAY = {
    "name": "relay",
    "states": ["x"],
    "parameters": {"k": 1.0, "c": 0.3, "tau": 0.7, "r": 0.1},
    "modes": {"warm": {"x'": "1 - k*x(t - tau - c*x)"}, "cold": {"x'": "-1 - k*x(t - tau - c*x)"}},
    "events": {"top": "x - 0.5", "bottom": "x + 0.4"},
    "resets": {"kick": {"x": "x - r"}},
    "segments": {
        "heat": {"mode": "warm", "event": "top", "direction": "rising", "reset": "kick", "to": "cold"},
        "cool": {"mode": "cold", "event": "bottom", "direction": "falling", "to": "warm"},
    },
    "initial": {"x": 0, "mode": "warm"},
}


def follow_clock(c):
    """Return b, y(b) and y between b and b + 1 of the clock's follower: there y' = -(1 + c) y + t - 1/2 - n."""
    rate = 1.0 + c

    def after(b, y, t):
        # y = A exp(-rate s) + s / rate + B with s = t - b, and u = s - c (y - y(b)) read from zero on.
        start = -b + b + c * y
        base = start / rate - 1.0 / rate**2
        return (y - base) * np.exp(-rate * (t - b)) + (t - b) / rate + base

    y = scipy.optimize.brentq(lambda y: after(0.0, y, 1.0) - y, -1.0, 2.0, xtol=1e-15)
    # b - 1/2 - c y(b) is a whole number.
    b = (0.5 + c * y) % 1.0
    return b, y, lambda t: after(b, y, b + (t - b) % 1.0)


class Clock:
    """The clock and its follower as a cycle to begin from, off by so much."""

    signature, times, n_periods, mode = ("tick",), np.array([0.0, 1.0]), 1, "m"

    def __init__(self, c, off=1e-3):
        self.known, self.off = follow_clock(c)[2], off

    def evaluate(self, segment, t):
        return np.stack([t, self.known(t) + self.off * np.sin(2 * np.pi * t)], axis=1)


def solve_clock(rule, c=0.25):
    numeric = numeric_from(to_yaml({**CLOCK, "parameters": {"c": c}}))
    return solve_orbit(guess_from_cycle(numeric, numeric.parameter_values, Direct(), Clock(c), rule), rule).at.orbit


@pytest.mark.parametrize("c", [0.25, -0.4, 0.0])
def test_a_breaking_time_in_closed_form(c):
    b, _, known = follow_clock(c)
    orbit = solve_clock(MeshRule(6, None, 1e-12), c)
    assert orbit.mesh.breaking[0].level == 1
    assert np.min(np.abs(orbit.breaking - b)) < 1e-13
    # At the segment's start y is that of its end; x jumps there.
    times = orbit.mesh.base_times(orbit.theta)
    assert np.max(np.abs(orbit.values[:, 1] - known(times))) < 1e-12


def test_a_guess_has_the_breaking_times_of_its_cycle():
    """As exactly as the cycle is known: on a mesh without them they would be off by parts of an interval."""
    numeric = numeric_from(to_yaml(CLOCK))
    cycle, rule = Clock(0.25, off=0.0), MeshRule(6, None, 1e-8)
    guess = guess_from_cycle(numeric, numeric.parameter_values, Direct(), cycle, rule)
    assert guess.mesh.n_breaking
    assert np.min(np.abs(guess.breaking - follow_clock(0.25)[0])) < 1e-7
    times = guess.mesh.grid(np.linspace(0, 1, 9))
    missed = guess.mesh.interpolate(guess.values, times) - cycle.evaluate(0, guess.mesh.times(times) @ guess.theta)
    assert np.max(np.abs(missed)) < 1e-7


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_values_converge_as_with_constant_delays(degree):
    """The order inside intervals is m + 1, though y' jumps at a time that depends on y."""
    known = follow_clock(0.25)[2]
    errors = []
    for n in (12, 24):
        orbit = solve_clock(MeshRule(degree, n, None))
        errors.append(np.max(np.abs(orbit.values[:, 1] - known(orbit.mesh.base_times(orbit.theta)))))
    assert np.log2(errors[0] / errors[1]) > degree + 0.7


@pytest.fixture(scope="module")
def relay():
    return settle_to_orbit(RELAY, mesh={"degree": 4, "tol": 1e-9})


def test_each_breaking_time_reads_its_source(relay):
    mesh, theta = relay.mesh, relay.theta
    assert mesh.n_breaking >= 3
    reads = relay.read(mesh.locate(theta, relay.breaking)[0].clipped())
    for b, breaking, lag in zip(relay.breaking, mesh.breaking, reads.lags[0], strict=True):
        assert b - lag == pytest.approx(breaking.source @ theta, abs=1e-12)
    found = {round(b, 9) for times in PreimageSearch(relay).find(0, relay.event_times[1:]) for b, _ in times}
    assert found <= {round(b, 9) for b in relay.breaking}
    # They need no Newton's method to be there nearly to rounding.
    search = PreimageSearch(relay)
    for b, breaking in zip(relay.breaking, mesh.breaking, strict=True):
        near = [other for other, _ in search.find(0, np.array([breaking.source @ theta % relay.period]))[0]]
        assert min(abs(other - b) for other in near) < 1e-12


def test_rounding_hides_no_time_at_an_edge(relay):
    """What is read at an edge is known twice, and a moment may lie between the two by rounding: it is read there."""
    search, mesh, theta = PreimageSearch(relay), relay.mesh, relay.theta
    edges = (mesh.start @ theta)[~np.isin(np.arange(mesh.n_intervals), mesh.last_interval + 1)][1:]
    lags = relay.read(mesh.locate(theta, edges)[0].clipped()).lags[0]
    for edge, read in zip(edges, (edges - lags) % relay.period, strict=True):
        found = search.find(0, read + 2.0**-54 * np.arange(-40, 41))
        assert all(min([abs(time - edge) for time, _ in times], default=1.0) < 1e-12 for times in found)


def test_derivatives_are_those_of_the_residuals(relay):
    orbit = relay.with_free(("k", "c", "tau"))
    system = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit))
    jacobian, h = system.at(orbit.x).jacobian().toarray(), 1e-5
    for column, unit in enumerate(h * np.eye(len(orbit.x))):
        near = system.at(orbit.x + unit).residual - system.at(orbit.x - unit).residual
        far = system.at(orbit.x + 2 * unit).residual - system.at(orbit.x - 2 * unit).residual
        assert jacobian[:, column] == pytest.approx((8 * near - far) / (12 * h), abs=1e-8 * np.max(np.abs(jacobian)))


def test_a_constant_delay_written_as_one_that_varies(relay):
    """The same numbers to rounding, on the same mesh: states, durations, multipliers."""
    constant = {**RELAY, "parameters": {"k": 1.0, "tau": 0.7, "r": 0.1}}
    constant["modes"] = {name: {"x'": f["x'"].replace(" - c*x", "")} for name, f in RELAY["modes"].items()}
    mesh = {"degree": 4, "intervals": 24}
    a, b = settle_to_orbit(constant, mesh=mesh), settle_to_orbit(RELAY, {"c": 0.0}, mesh=mesh)
    assert b.mesh.n_breaking
    assert np.max(np.abs(a.values - b.values)) < 1e-12
    assert np.max(np.abs(a.durations - b.durations)) < 1e-12
    mu, nu = find_multipliers(a).values, find_multipliers(b).values
    n = min(len(mu), len(nu))
    assert n and np.max(np.abs(mu[:n] - nu[:n])) < 1e-12


def test_breaking_times_pass_events_and_vanish(relay):
    """From c = .3 to c = .34 the first one reaches the end of its segment, and with it go those that follow from it."""
    numeric, rule, orbit = relay.numeric, MeshRule(4, None, 1e-9), relay
    counts = []
    for c in np.linspace(0.3, 0.34, 9):
        p = orbit.problem.parameters.copy()
        p[numeric.parameter_index("c")] = c
        orbit = solve_orbit(Orbit(replace(orbit.problem, parameters=p), orbit.x), rule).at.orbit
        counts.append(orbit.mesh.n_breaking)
    assert counts[0] > counts[-1] > 0


def test_a_mesh_with_breaking_times_to_a_row_and_back(relay):
    again = mesh_from_row(mesh_to_row(relay.mesh))
    assert np.array_equal(again.reference_lags, relay.mesh.reference_lags)
    for a, b in zip(again.breaking, relay.mesh.breaking, strict=True):
        assert (a.delay, a.level, a.source.tolist()) == (b.delay, b.level, b.source.tolist())
    with pytest.raises(ValueError, match="not that of a mesh"):
        mesh_from_row(mesh_to_row(relay.mesh)[:-1])


# The clock, followed by what integrates it: y' = -y + integral of frac(t - s) over s from 0.3 to 0.9.
INTEGRATING = {**CLOCK, "parameters": {"a": 0.3, "w": 0.6}}
LIMITS = {"parameters": "integral(x(t - s), s, a, a + w)", "numbers": "integral(x(t - s), s, 0.3, 0.9)"}


def follow_integral(t):
    """Return y at ``t``: the integral of exp(-s) V(t - s) over one period, and all before it, by quadrature.

    V(u), the integral of frac(u - s), is 0.6 (u - 0.6) and by one more for the lags beyond u.
    """
    nodes, weights = np.polynomial.legendre.leggauss(20)

    def integrate(u):
        u = u % 1.0
        return 0.6 * (u - 0.6) + np.where(u < 0.3, 0.6, np.where(u < 0.9, 0.9 - u, 0.0))

    cuts = np.sort(np.array([0.0, 1.0, t % 1.0, (t - 0.3) % 1.0, (t - 0.9) % 1.0]))
    lags = 0.5 * (cuts[1:] + cuts[:-1])[:, None] + 0.5 * np.diff(cuts)[:, None] * nodes
    total = np.sum(0.5 * np.diff(cuts)[:, None] * weights * np.exp(-lags) * integrate(t - lags))
    return total / -np.expm1(-1.0)


class Integrating:
    """The clock and what integrates it as a cycle to begin from, roughly."""

    signature, times, n_periods, mode = ("tick",), np.array([0.0, 1.0]), 1, "m"

    def evaluate(self, segment, t):
        return np.stack([t, [follow_integral(s) + 1e-3 * np.sin(2 * np.pi * s) for s in t]], axis=1)


@pytest.mark.parametrize("written", LIMITS)
def test_limits_of_integrals_bring_jumps_back(written):
    """They are edges of the mesh, so that two intervals a piece leave rounding alone."""
    numeric = numeric_from(to_yaml({**INTEGRATING, "modes": {"m": {"x'": "1", "y'": f"-y + {LIMITS[written]}"}}}))
    rule = MeshRule(8, 6, None)
    orbit = solve_orbit(guess_from_cycle(numeric, numeric.parameter_values, Direct(), Integrating(), rule), rule)
    orbit = orbit.at.orbit
    starts = [float(piece.start @ orbit.theta) for piece in orbit.mesh.pieces]
    assert {0.0, 0.3, 0.9} <= {round(start, 12) for start in starts}
    times = orbit.mesh.base_times(orbit.theta)
    assert np.max(np.abs(orbit.values[:, 1] - [follow_integral(t) for t in times])) < 1e-13
