"""Shipped models that are given by their equations, against closed forms and calculations apart from the program."""

import math
from itertools import pairwise

import numpy as np
import pytest
import yaml
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from pddecont.model import load_model
from pddecont.model.system import make_symbol
from tests.conftest import ROOT
from tests.models.linear_pieces import Flow
from tests.models.method_of_steps import Motion, same
from tests.runs import change, labels, monitor, multipliers, parameter, run

FINE = {"degree": 9, "tol": 1e-12}


def field(model, mode, values):
    """Return a mode's vector field where states and parameters have ``values``."""
    found = load_model(str(ROOT / "models" / f"{model}.yaml"))[0]
    values = {make_symbol(name): v for name, v in {**found.parameters, **values}.items()}
    return [float(f.xreplace(values)) for f in found.modes[mode]]


def shipped_run(model, path, n_steps=None, **more):
    """Return the results of a shipped model's own run, or of its first steps."""
    block = read_model(model)["run"]
    return run({"model": model, **block, "steps": block["steps"][:n_steps], **more}, path / "a.h5")


def read_model(name):
    """Return the mapping of a shipped model's file."""
    return yaml.safe_load((ROOT / "models" / f"{name}.yaml").read_text())


def test_the_block_on_a_belt_sticks_and_slips_for_the_times_of_the_closed_form(tmp_path):
    """Slip is an arc of a circle round (fk, 0), from tearing off at x = fs to x = 2 fk - fs, both at speed vb."""
    results = shipped_run("friction_belt", tmp_path, mesh=FINE)
    step = results.step("in_speed")
    vb = parameter(step, "vb")
    stick = 2 * 0.3 / vb
    assert monitor(step, "sticking") == pytest.approx(stick, rel=1e-12)
    period = stick + 2 * math.pi - 2 * np.arctan(0.3 / vb)
    assert step.points["period"][step.order] == pytest.approx(period, rel=1e-12)
    assert monitor(step, "amplitude") == pytest.approx(np.hypot(0.3, vb), rel=1e-11)
    assert np.abs(multipliers(results.step("orbit"))) == pytest.approx(0, abs=1e-12)


class DryFriction:
    """x'' + c x' + x = a cos(om t) - F sgn x' in closed form between two turns."""

    def __init__(self, om, a=1.5, F=1.0, c=0.1):
        self.om, self.a, self.F, self.c = om, a, F, c
        self.G = a / (1 - om**2 + 1j * om * c)
        root = np.sqrt(complex(c * c / 4 - 1))
        self.roots = np.array([-c / 2 + root, -c / 2 - root])

    def slide(self, t0, x0, side):
        """Return x(t), v(t) of the motion that starts at rest and moves to a side."""
        z = self.G * np.exp(1j * self.om * t0)
        rest = np.array([x0 + side * self.F - z.real, -(1j * self.om * z).real])
        weights = np.linalg.solve(np.array([[1, 1], self.roots]), rest)

        def x(t):
            powers = np.exp(np.multiply.outer(t - t0, self.roots))
            return (self.G * np.exp(1j * self.om * t)).real - side * self.F + (powers @ weights).real

        def v(t):
            powers = np.exp(np.multiply.outer(t - t0, self.roots))
            return (1j * self.om * self.G * np.exp(1j * self.om * t)).real + (powers @ (weights * self.roots)).real

        return x, v

    def settle(self, n_turns=60):
        """Return turns (time, place, time of sticking) of the motion that starts at rest at zero."""
        t, x0, turns = 0.0, 0.0, []
        for _ in range(n_turns):
            # Force a cos(om t) - x0: the motion sticks until it is more than F.
            late = 0.0
            force = self.a * math.cos(self.om * t) - x0
            if abs(force) <= self.F:
                after = t + np.linspace(0, 2 * math.pi / self.om, 2001)
                k = int(np.argmax(self._beyond(after[1:], x0) > 0)) + 1
                leave = brentq(self._beyond, after[k - 1], after[k], args=(x0,), xtol=1e-15)
                late, t = leave - t, leave
                side = np.sign(self.a * math.cos(self.om * (t + 1e-6)) - x0)
            else:
                side = np.sign(force)
            turns.append((t - late, x0, late))
            x, v = self.slide(t, x0, side)
            s = t + np.linspace(1e-4, 2 * math.pi / self.om, 4001)
            k = int(np.argmax(v(s) * side < 0))
            t = brentq(v, s[k - 1], s[k], xtol=1e-15)
            x0 = x(t)
        return turns

    def _beyond(self, t, x0):
        return np.abs(self.a * np.cos(self.om * t) - x0) - self.F

    @staticmethod
    def miss(om):
        """Return the size of (cos, sin) of the phase at which a motion turns with just the friction on it, less 1.

        It moves from -X to X in half a period, turns at X, and there a cos(phase) = X - F.
        """
        a, F, c = 1.5, 1.0, 0.1
        flow = Flow([[0, 1, 0, 0], [-1, -c, a, 0], [0, 0, 0, -om], [0, 0, om, 0]], [0, 0, 0, 0])
        pushed = Flow(flow.matrix[:4, :4], [0, F, 0, 0])
        # From rest at X with phase (p, q), moving down: linear in X, p, q.
        zero = pushed(np.zeros(4), math.pi / om)
        X, p, q = (pushed(e, math.pi / om) - zero for e in (np.eye(4)[0], np.eye(4)[2], np.eye(4)[3]))
        A = np.array([[X[0] + 1, p[0], q[0]], [X[1], p[1], q[1]], [-1, a, 0]])
        _, p, q = np.linalg.solve(A, [-zero[0], -zero[1], -F])
        return math.hypot(p, q) - 1


def test_dry_friction_begins_to_stick_where_the_force_at_a_turn_is_the_friction(tmp_path):
    results = shipped_run("dry_friction", tmp_path)
    step = results.step("in_frequency")
    assert labels(step) == ["CS1", "CS2"]
    for label, low, high in (("CS1", 0.7, 0.75), ("CS2", 1.2, 1.25)):
        exact = brentq(DryFriction.miss, low, high, xtol=1e-15)
        assert parameter(step, "om", label) == pytest.approx(exact, abs=1e-11)
    # Two turns a period on either side of the points, sticking at both of them outside.
    om, sticking = parameter(step, "om"), monitor(step, "sticking")
    outside = (om < 0.7226791944) | (om > 1.2357471524)
    assert outside.sum() >= 10
    assert np.all(sticking[~outside] == 0)
    rows = step.order[outside]
    for i in rows[:: len(rows) // 10]:
        k = list(step.order).index(i)
        turns = DryFriction(om[k]).settle()[-2:]
        assert monitor(step, "amplitude")[k] == pytest.approx(abs(turns[0][1] - turns[1][1]) / 2, abs=1e-9)
        assert sticking[k] == pytest.approx(turns[0][2] + turns[1][2], abs=1e-8)


class TwoBlocks:
    """Two blocks on a belt, coupled; each flow is linear."""

    def __init__(self, k, vb=0.5, f=(0.7, 0.8), s=(1.0, 1.2)):
        self.vb, self.s = vb, s
        self.K = np.array([[1 + k, -k], [-k, 1 + k]])
        self.flows = {}
        for slips in ((0, 0), (0, 1), (1, 0), (1, 1)):
            A, b = np.zeros((4, 4)), np.zeros(4)
            for i in range(2):
                if slips[i]:
                    A[i, 2 + i], A[2 + i, :2], b[2 + i] = 1, -self.K[i], f[i]
                else:
                    b[i] = vb
            self.flows[slips] = Flow(A, b)

    def cycle(self, gap):
        """Return (period, time in which both stick, x2 - x1) from where the first tears off to the next time.

        Both stick before; ``gap`` is x2 - x1 then. States are x1, x2, v1, v2.
        """
        x1 = brentq(lambda x: self.K[0] @ [x, x + gap] - self.s[0], -5, 5, xtol=1e-15)
        z, slips, time, both = np.array([x1, x1 + gap, self.vb, self.vb]), (1, 0), 0.0, 0.0
        while True:
            found = []
            for i in range(2):
                ends = self._caught(i) if slips[i] else self._torn(i)
                # A block that has just torn off is below the speed of the belt.
                try:
                    found.append((self.flows[slips].time_to(z, ends, 8.0, after=1e-6), i))
                except ValueError:
                    continue
            t, i = min(found)
            both += t if slips == (0, 0) else 0.0
            time, z = time + t, self.flows[slips](z, t)
            slips = tuple(1 - s if j == i else s for j, s in enumerate(slips))
            if not slips[i]:
                z[2 + i] = self.vb
            elif i == 0 and slips == (1, 0):
                return time, both, z[1] - z[0]

    def _caught(self, i):
        return lambda z: z[2 + i] - self.vb

    def _torn(self, i):
        return lambda z: self.K[i] @ z[:2] - self.s[i]


def test_two_blocks_stick_together_as_the_map_of_their_gap_says(tmp_path):
    results = shipped_run("two_blocks", tmp_path, mesh={"degree": 9, "tol": 1e-11})
    step = results.step("in_coupling")
    k = parameter(step, "k")

    def settled(coupling):
        blocks = TwoBlocks(coupling)
        # Beyond the largest gap the second block tears off first; where it is small neither stops for long.
        largest = 0.2 / (1 + 2 * coupling) - 1e-6
        gap = brentq(lambda g: blocks.cycle(g)[2] - g, 0.65 * largest, largest, xtol=1e-14)
        return blocks, gap

    for i in (0, len(k) // 2, len(k) - 1):
        blocks, gap = settled(k[i])
        period, both, _ = blocks.cycle(gap)
        assert step.points["period"][step.order[i]] == pytest.approx(period, abs=1e-9)
        assert monitor(step, "both_stick")[i] == pytest.approx(both, abs=1e-9)
    blocks, gap = settled(parameter(step, "k", "PD1"))
    slope = (blocks.cycle(gap + 1e-5)[2] - blocks.cycle(gap - 1e-5)[2]) / 2e-5
    assert slope == pytest.approx(-1, abs=1e-7)


class Relay:
    """The plant of the relay: a symmetric orbit's half period from where it leaves x1 = 0 upwards."""

    def __init__(self, rho, zeta=0.25, omega=2.0, lam=1.0, k=1.0, sigma=-1.0):
        A = np.array(
            [[-(2 * zeta * omega + lam), 1, 0], [-(2 * zeta * omega * lam + omega**2), 0, 1], [-lam * omega**2, 0, 0]]
        )
        self.k, self.B = k, np.array([k, 2 * k * sigma * rho, k * rho**2])
        self.above = Flow(A, -self.B)
        # On the surface u = -x2 / k keeps x1 at zero.
        slide = A - np.outer(self.B, A[0]) / k
        self.on = Flow(slide, np.zeros(3))

    def half(self, x3):
        """Return (time, time of sliding, x3) from leaving at x2 = k to where -x leaves so."""
        z = np.array([0.0, self.k, x3])
        t = self.above.time_to(z, lambda z: z[0], 10.0, after=1e-4)
        z = self.above(z, t)
        assert abs(z[1]) < self.k, "it crosses"
        slid = self.on.time_to(z, lambda z: z[1] + self.k, 20.0)
        return t + slid, slid, -self.on(z, slid)[2]

    def miss(self, half):
        """Return x1 where the orbit of half period ``half`` that does not slide changes sign, and there x2 - k."""
        moved = self.above(np.zeros(3), half)
        M = np.array([self.above(e, half) - moved for e in np.eye(3)]).T
        z = np.linalg.solve(np.eye(3) + M, -moved)
        return z[0], z[1] - self.k


def test_the_relay_slides_along_the_equivalent_control(tmp_path):
    x2, x3, rho, sigma = 0.3, -0.7, 0.5, -1.0
    slope = field("relay_sliding", "output_on", {"x1": 0, "x2": x2, "x3": x3})
    assert slope == pytest.approx([0, x3 - 2 * sigma * rho * x2, -(rho**2) * x2], abs=1e-15)
    results = shipped_run("relay_sliding", tmp_path, mesh={"degree": 9, "tol": 1e-11})
    step = results.step("in_zeros")
    assert labels(step) == ["CS1"]

    def crossing(rho):
        relay = Relay(rho)
        half = brentq(lambda h: relay.miss(h)[0], 1.8, 2.6, xtol=1e-15)
        return relay.miss(half)[1]

    exact = brentq(crossing, 1.3, 1.7, xtol=1e-15)
    # The point is recorded where a segment still lasts 1e-9 of the period.
    assert parameter(step, "rho", "CS1") == pytest.approx(exact, abs=1e-7)
    sliding = np.flatnonzero(parameter(step, "rho") < exact - 1e-3)
    for i in sliding[:: max(len(sliding) // 6, 1)]:
        relay, last = Relay(parameter(step, "rho")[i]), 0.0
        for _ in range(30):
            half, slid, last = relay.half(last)
        assert step.points["period"][step.order[i]] == pytest.approx(2 * half, abs=1e-9)
        assert monitor(step, "sliding")[i] == pytest.approx(2 * slid, abs=1e-8)


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
            for column in ("parameters", "monitors", "period"):
                a, b = (s.points[column][i] for s, i in zip((step, other), rows, strict=True))
                assert a == pytest.approx(b, rel=1e-11, abs=1e-11, nan_ok=True), (name, label, column)
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
        {"m": flow}, {"m": kinks}, (tau,), lambda t: [0.5, 0.5, 0.5, 1.6, 1.45], "m", echoes=1, accuracy=1e2
    ).run(150)
    times = motion.times("02.0")
    assert step.points["period"][0] == pytest.approx(times[-1] - times[-3], abs=1e-8)
    assert monitor(step, "v1_max")[0] == pytest.approx(motion.highest(0, times[-3], times[-1]), abs=1e-8)
