"""Shipped converters, thermostats, gears, cars and predators, against calculations apart from the program."""

import math
from itertools import pairwise

import numpy as np
import pytest
import yaml
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from tests.conftest import ROOT
from tests.models.linear_pieces import Flow
from tests.models.method_of_steps import Motion, same
from tests.models.switched import FINE, field, read_model, shipped_run
from tests.runs import change, labels, monitor, multipliers, parameter, run


class Ramped:
    """A converter under a ramp of period T: z' = A z + b in the part before the ramp meets the signal, and after."""

    def __init__(self, first, second, signal, T):
        self.first, self.second, self.signal, self.T = first, second, signal, T

    def start(self, t):
        """Return the state at the beginning of a period that repeats itself if the parts meet at ``t``."""
        zero = self.second(self.first(np.zeros(2), t), self.T - t)
        M = np.array([self.second(self.first(e, t), self.T - t) - zero for e in np.eye(2)]).T
        return np.linalg.solve(np.eye(2) - M, zero)

    def orbit(self):
        """Return the state at the beginning, and when the parts meet."""
        t = brentq(
            lambda t: self.signal(self.first(self.start(t), t), t),
            1e-3 * self.T,
            0.999 * self.T,
            xtol=1e-19,
            rtol=1e-15,
        )
        return self.start(t), t

    def multipliers(self, slope, ramp):
        """Return the multipliers; the signal's gradient in the states is ``slope``, its rate in time ``ramp``."""
        z, t = self.orbit()
        z = self.first(z, t)
        before, after = self.first.slope(z), self.second.slope(z)
        jump = np.eye(2) + np.outer(after - before, slope) / (np.dot(slope, before) + ramp)
        parts = [np.array([f(e, s) - f(np.zeros(2), s) for e in np.eye(2)]).T for f, s in self.parts(t)]
        return np.linalg.eigvals(parts[1] @ jump @ parts[0])

    def parts(self, t):
        """Return each part with its duration."""
        return (self.first, t), (self.second, self.T - t)

    def highest(self, state, n=2001):
        """Return a state's maximum, from samples refined at an extremum inside a part."""
        z, meet = self.orbit()
        found = []
        for flow, length in self.parts(meet):
            times = np.linspace(0, length, n)
            rates = [flow.slope(flow(z, s))[state] for s in times]
            found += [flow(z, 0)[state], flow(z, length)[state]]
            for k in np.flatnonzero(np.diff(np.sign(rates)) < 0):
                top = brentq(lambda s, f=flow, z=z: f.slope(f(z, s))[state], times[k], times[k + 1], xtol=1e-19)
                found.append(flow(z, top)[state])
            z = flow(z, length)
        return max(found)


def buck(E, R=22.0, C=0.047, L=20.0, T=0.4, gamma=11.75238, rise=0.5238096):
    A = [[-1 / (R * C), 1 / C], [-1 / L, 0]]
    return Ramped(Flow(A, [0, 0]), Flow(A, [0, E / L]), lambda z, t: z[0] - gamma - rise * t / T, T)


def test_the_buck_converter_doubles_its_period_where_hamill_and_deane_say(tmp_path):
    step = shipped_run("buck_converter", tmp_path).step("in_supply")

    def miss(E):
        return np.prod(buck(E).multipliers([1, 0], -0.5238096 / 0.4).real + 1)

    exact = brentq(miss, 24.3, 24.8, xtol=1e-13)
    assert exact == pytest.approx(24.5166, abs=5e-5)
    assert parameter(step, "E", "PD1") == pytest.approx(exact, abs=1e-8)
    for i in range(0, len(step.order), 8):
        assert monitor(step, "v_max")[i] == pytest.approx(buck(parameter(step, "E")[i]).highest(0), abs=1e-8)


def boost(ref, E=10.0, R=20.0, C=0.012, L=1.5, T=0.2, rise=1.5):
    load = Flow([[-1 / (R * C), 0], [0, 0]], [0, E / L])
    feed = Flow([[-1 / (R * C), 1 / C], [-1 / L, 0]], [0, E / L])
    return Ramped(load, feed, lambda z, t: z[1] + rise * t / T - ref, T)


def test_the_boost_converter_feeds_from_the_reference_on(tmp_path):
    results = shipped_run("boost_converter", tmp_path)
    step = results.step("in_reference")
    for i in range(0, len(step.order), 8):
        exact = boost(parameter(step, "ref")[i])
        assert monitor(step, "v_max")[i] == pytest.approx(exact.highest(0), abs=1e-8)
        assert monitor(step, "i_max")[i] == pytest.approx(exact.highest(1), abs=1e-9)
    found = np.sort_complex(multipliers(results.step("orbit")))
    assert found == pytest.approx(np.sort_complex(boost(2.0).multipliers([0, 1], 1.5 / 0.2)), abs=1e-8)


def test_the_thermostat_swings_by_its_dead_time(tmp_path):
    step = shipped_run("thermostat", tmp_path, mesh=FINE).step("in_delay")
    tau = parameter(step, "tau")
    hottest, coldest = 3 + (1.4 - 3) * np.exp(-tau), np.exp(-tau)
    assert monitor(step, "hottest") == pytest.approx(hottest, abs=1e-11)
    assert monitor(step, "coldest") == pytest.approx(coldest, abs=1e-11)
    heating = tau + np.log((3 - coldest) / (3 - 1.4))
    assert monitor(step, "heating") == pytest.approx(heating, abs=1e-11)
    period = heating + tau + np.log(hottest / 1.0)
    assert step.points["period"][step.order] == pytest.approx(period, abs=1e-11)


def test_harvested_predators_stay_at_their_limit_until_there_is_little_prey(tmp_path):
    """On the limit the prey alone moves, from where the predators come to it to where they decline unharvested."""
    a, b, d, E = 0.3556, 0.33, 0.0444, 0.2067
    x, y = 0.4, 1.5
    slope = field("harvested_predators", "many_on", {"x": x, "y": y})
    assert slope == pytest.approx([x * (1 - x) - a * x * y / (b + x), 0], abs=1e-15)
    step = shipped_run("harvested_predators", tmp_path).step("in_limit")
    few = b * d / (a - d)

    def flow(t, z):
        caught = a * z[0] * z[1] / (b + z[0])
        return [z[0] * (1 - z[0]) - caught, caught - d * z[1]]

    limits = parameter(step, "limit")
    for i in (0, len(limits) // 3, len(limits) // 2, len(limits) - 4):
        limit = limits[i]

        def back(t, z, limit=limit):
            return z[1] - limit if t > 1 else -1.0

        back.direction, back.terminal = 1, True
        free = solve_ivp(flow, (0, 200), [few, limit], method="DOP853", rtol=1e-12, atol=1e-14, events=back)
        t, ((met, _),) = free.t_events[0][0], free.y_events[0]
        assert met < b * (d + E) / (a - d - E), "predators would grow although harvested"
        slid = quad(lambda x, y=limit: 1 / (a * x * y / (b + x) - x * (1 - x)), few, met, epsabs=1e-12, epsrel=1e-12)[0]
        assert monitor(step, "sliding")[i] == pytest.approx(slid, abs=1e-7)
        assert step.points["period"][step.order[i]] == pytest.approx(t + slid, rel=1e-8)
        assert monitor(step, "prey_max")[i] >= met - 1e-8


def test_gears_come_off_their_teeth_as_by_the_method_of_steps(tmp_path):
    results = shipped_run("gear_backlash", tmp_path, 2, mesh={"degree": 9, "tol": 1e-11})
    om, tau = 0.6, 1.0

    def mesh(t, z, past):
        x, v = z
        tooth = x - 1 if x > 1 else x + 1 if x < -1 else 0.0
        return [v, 0.1 + 0.2 * math.cos(om * t) - 0.1 * v + 0.02 * (past(tau)[1] - v) - tooth]

    motion = Motion(
        {"m": mesh},
        {
            "m": [
                (lambda t, z, past: z[0] - 1, 0, same, "m", "front"),
                (lambda t, z, past: z[0] + 1, 0, same, "m", "back"),
                (lambda t, z, past: z[1], -1, same, "m", "top"),
            ]
        },
        (tau,),
        lambda t: [1.1, 0.0],
        "m",
        echoes=1,
        accuracy=0.1,
    ).run(100 * 2 * math.pi / om)
    last = motion.at - 2 * math.pi / om
    tops = [z[0] for name, t, z in motion.events if name == "top" and t > last]
    orbit = results.step("orbit")
    assert monitor(orbit, "x_max")[0] == pytest.approx(max(tops), abs=1e-9)
    crossings = [(name, t, z[1]) for name, t, z in motion.events if name != "top" and t > last]
    crossings.append((crossings[0][0], crossings[0][1] + 2 * math.pi / om, crossings[0][2]))
    # Off the teeth: below the front ones after falling through x = 1, above the back ones after rising through x = -1.
    loss = sum(
        b[1] - a[1] for a, b in pairwise(crossings) if (a[0] == "front" and a[2] < 0) or (a[0] == "back" and a[2] > 0)
    )
    assert monitor(orbit, "loss")[0] == pytest.approx(loss * om / (2 * math.pi), abs=1e-9)


HAND_WRITTEN_GEAR = {
    "modes": {
        "front": {"x'": "v", "v'": "rest - (x - b)"},
        "gap": {"x'": "v", "v'": "rest"},
        "back": {"x'": "v", "v'": "rest - (x + b)"},
    },
    "events": {"upper": "x - b", "lower": "x + b"},
    "segments": {
        "drive": {"mode": "front", "event": "upper", "direction": "falling", "to": "gap"},
        "fall": {"mode": "gap", "event": "lower", "direction": "falling", "to": "back"},
        "rise": {"mode": "gap", "event": "upper", "direction": "rising", "to": "front"},
        "coast": {"mode": "back", "event": "lower", "direction": "rising", "to": "gap"},
    },
}


def by_hand_gear():
    """Return the gears with modes written by hand."""
    data = read_model("gear_backlash")
    rest = "F0 + F1*cos(omega*t) - 2*zeta*v + K*(v(t - tau) - v)"
    left = {k: v for k, v in data.items() if k not in ("switches", "equations", "effects")}
    hand = {**left, **HAND_WRITTEN_GEAR, "definitions": {"rest": rest}}
    hand["initial"] = {"mode": "front", **data["initial"]}
    return change(hand, "run.monitors.loss", "time_in(gap)/period")


def by_hand_cars():
    """Return the ring of cars with its 27 modes written by hand, and the branch of the shipped model."""
    data = yaml.safe_load((ROOT / "tests" / "cases" / "cars.yaml").read_text())
    block = read_model("ring_of_cars")["run"]
    return {**data, "run": {**block, "steps": block["steps"]}}


@pytest.mark.parametrize(
    ("model", "by_hand"),
    [
        ("gear_backlash", by_hand_gear),
        ("ring_of_cars", by_hand_cars),
        ("impact_oscillator_max", lambda: read_model("impact_oscillator")),
    ],
)
def test_modes_that_are_made_are_as_good_as_modes_by_hand(model, by_hand, tmp_path):
    """The same labels at the same places, with the same monitors, periods and leading multipliers.

    Both are solved to the meshes' tolerance by the same steps: what is between them is rounding, a multiplier's
    magnified by the condition of its problem.
    """
    made = shipped_run(model, tmp_path)
    hand = run(by_hand(), tmp_path / "b.h5")
    for name, step in made.steps.items():
        if step.kind == "simulate":
            continue
        other = hand.step(name)
        assert labels(step) == labels(other)
        for label in [None, *labels(step)]:
            rows = (step.order[0], other.order[0]) if label is None else (step.row(label), other.row(label))
            at_rest = step.kind in ("equilibrium", "equilibria")
            for column in ("parameters", "states", "frequency") if at_rest else ("parameters", "monitors", "period"):
                a, b = (s.points[column][i] for s, i in zip((step, other), rows, strict=True))
                assert a == pytest.approx(b, rel=1e-11, abs=1e-11, nan_ok=True), (name, label, column)
            if at_rest:
                continue
            a, b = (multipliers(s, i)[:1] for s, i in zip((step, other), rows, strict=True))
            assert a == pytest.approx(b, abs=1e-8), (name, label)


def test_the_ring_of_cars_moves_as_by_the_method_of_steps(tmp_path):
    step = shipped_run("ring_of_cars", tmp_path, 2).step("orbit")
    tau, L, low, high = 0.3, 4.5, 1.0, 2.0

    def gaps(past):
        late = past(tau)
        return late[3], late[4], L - late[3] - late[4]

    def flow(t, z, past):
        wanted = [(min(max(gap, low), high) - low) / (high - low) for gap in gaps(past)]
        return [*(w - v for w, v in zip(wanted, z[:3], strict=True)), z[1] - z[0], z[2] - z[1]]

    kinks = [
        (lambda t, z, past, i=i, at=at: gaps(past)[i] - at, 0, same, "m", f"{i}{at}")
        for i in range(3)
        for at in (low, high)
    ]
    motion = Motion(
        {"m": flow}, {"m": kinks}, (tau,), lambda t: [0.5, 0.5, 0.5, 1.6, 1.45], "m", echoes=1, accuracy=1e0
    ).run(150)
    times = motion.times("02.0")
    assert step.points["period"][0] == pytest.approx(times[-1] - times[-3], abs=1e-8)
    assert monitor(step, "v1_max")[0] == pytest.approx(motion.highest(0, times[-3], times[-1]), abs=1e-8)
