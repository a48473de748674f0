"""Shipped models that stick and slide, against closed forms and calculations apart from the program."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.models.linear_pieces import Flow
from tests.models.switched import FINE, field, shipped_run
from tests.runs import labels, monitor, multipliers, parameter


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
    assert parameter(step, "rho", "CS1") == pytest.approx(exact, abs=1e-10)
    sliding = np.flatnonzero(parameter(step, "rho") < exact - 1e-3)
    for i in sliding[:: max(len(sliding) // 6, 1)]:
        relay, last = Relay(parameter(step, "rho")[i]), 0.0
        for _ in range(30):
            half, slid, last = relay.half(last)
        assert step.points["period"][step.order[i]] == pytest.approx(2 * half, abs=1e-9)
        assert monitor(step, "sliding")[i] == pytest.approx(2 * slid, abs=1e-8)
