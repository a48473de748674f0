"""Motions that stick and slide, relays, impacts: against closed forms; and how well they stay on their surface."""

import math

import numpy as np
import pytest

from pddecont.simulate import Method
from tests.runs import to_yaml
from tests.simulate.motions import TIGHT, trajectory_of

FORCED = {"name": "m", "states": ["x", "v"], "forcing": {"period": "2*pi"}}


def simulate(equations, initial, t_end, method=TIGHT, keep_from=0.0, **more):
    """Return the trajectory of a model of equations."""
    states = [key[:-1] for key in equations]
    given = {"name": "m", "states": states, "equations": equations, "initial": initial, **more}
    return trajectory_of(to_yaml(given), t_end, method, keep_from=keep_from)


@pytest.mark.parametrize("start", [0.35, 0.9, 3.3, 7.19])
def test_dry_friction_takes_as_much_of_every_half_turn(start):
    """x'' = -x - mu sign(v): each half turn lasts pi and takes 2 mu, until |x| is at most mu."""
    mu = 0.4
    t = simulate({"x'": "v", "v'": "-x - 0.4*sign(v)"}, {"x": start}, 40.0)
    stops, x = [], start
    while abs(x) > mu:
        x = -math.copysign(1.0, x) * (abs(x) - 2 * mu)
        stops.append(x)
    assert t.events.t == pytest.approx(math.pi * np.arange(1, len(stops) + 1), abs=1e-9)
    assert t.events.before[:, 0] == pytest.approx(stops, abs=1e-9)
    assert t(40.0) == pytest.approx([x, 0], abs=1e-9)
    assert t.mode[-1] == "v_on"


@pytest.mark.parametrize(("static", "holds"), [(0.5, True), (0.44, False)])
def test_static_friction_holds_what_kinetic_would_not(static, holds):
    """After half a turn from 1.25 the spring pulls with 0.45: kinetic friction is 0.4."""
    law = f"-x - coulomb(v, 0.4, {static})"
    t = simulate({"x'": "v", "v'": law}, {"x": 1.25}, 10.0)
    assert t.events.t[0] == pytest.approx(math.pi, abs=1e-10)
    end = -0.45 if holds else -0.35
    assert t(10.0) == pytest.approx([end, 0], abs=1e-9)
    assert len(t.events) == (1 if holds else 2)


def test_a_block_on_a_belt_sticks_until_the_spring_pulls_as_static_friction():
    """Belt speed 0.5, kinetic 0.3, static 0.45: sticking ends at x = 0.45, however often."""
    t = simulate({"x'": "v", "v'": "-x - coulomb(v - 0.5, 0.3, 0.45)"}, {"x": 0, "v": 0.5}, 60.0)
    leaves = [k for k, name in enumerate(t.events.segment) if "off" in name]
    assert len(leaves) >= 5
    assert t.events.before[leaves] == pytest.approx(np.tile([0.45, 0.5], (len(leaves), 1)), abs=1e-9)
    # Slipping is a turn about 0.3 from (0.15, 0.5) to (0.15 below, 0.5); sticking from there at the belt's speed.
    period = 2 * math.pi - 2 * math.atan2(0.15, 0.5) + 0.3 / 0.5
    assert np.diff(t.events.t[leaves]) == pytest.approx(period, abs=1e-9)


def test_along_a_slanted_surface_a_motion_decays_as_the_surface_says():
    """On v + x/2 = 0: x' = -x/2."""
    t = simulate({"x'": "v", "v'": "-0.3*x - 2*sign(v + 0.5*x)"}, {"x": 1, "v": -0.5}, 8.0)
    assert t(8.0) == pytest.approx(math.exp(-4.0) * np.array([1, -0.5]), abs=1e-11)


def test_a_relay_with_memory_turns_at_its_thresholds():
    """x' = -1 above and 1 below, between -0.3 and 0.7: a period is twice the way."""
    t = simulate({"x'": "-hysteresis(x, -0.3, 0.7)"}, {"x": 0}, 10.0)
    assert t.events.t == pytest.approx(0.7 + np.arange(10), abs=1e-11)
    assert t.events.before[:, 0] == pytest.approx(np.where(np.arange(10) % 2, -0.3, 0.7), abs=1e-11)


def test_a_sawtooth_and_a_square_wave_are_integrated():
    """Of mod(t, 2) a period gives 2, of square(t, 2) nothing; after 7.25 the rests are 1.25**2/2 and 1 - 0.25."""
    more = {"forcing": {"period": 2}}
    t = simulate({"x'": "mod(t, 2)", "y'": "square(t, 2)"}, {}, 7.25, **more)
    assert t(7.25) == pytest.approx([6 + 1.25**2 / 2, 0.75, 1.25], abs=1e-11)


def test_doses_add_up():
    """x' = -x with 1 more at every multiple of 0.5, not at 0: after 3.25 six of them are left in part."""
    t = simulate(
        {"x'": "-x"}, {"x": 2}, 3.25, forcing={"period": 0.5}, jumps={"dose": {"every": 0.5, "reset": {"x": "x + 1"}}}
    )
    expected = 2 * math.exp(-3.25) + sum(math.exp(-(3.25 - 0.5 * k)) for k in range(1, 7))
    assert t(3.25) == pytest.approx([expected], abs=1e-11)


def test_a_kick_follows_each_impact():
    """v = 1 up to the stop at 0.5, where it turns with 0.8; 0.2 later it is kicked up again by 1.5."""
    jumps = {
        "stop": {"at": "x - 0.5", "direction": "rising", "reset": {"v": "-0.8*v"}},
        "kick": {"after": "stop", "delay": 0.2, "reset": {"v": "v + 1.5"}},
    }
    t = simulate({"x'": "v", "v'": "0"}, {"x": 0, "v": 1}, 1.5, jumps=jumps)
    # Up again with 0.7 from 0.5 - 0.16, at 0.5 after 0.16/0.7; then back with 0.56.
    second = 0.7 + 0.16 / 0.7
    assert t.events.t[:4] == pytest.approx([0.5, 0.7, second, second + 0.2], abs=1e-11)
    assert t.events.after[:4, 1] == pytest.approx([-0.8, 0.7, -0.56, 0.94], abs=1e-11)


def test_friction_ends_with_its_normal_force():
    """A mass sticks while it is pressed down; the pressure falls as 1 - t/3, the spring pulls with 0.5."""
    t = simulate(
        {"x'": "v", "v'": "-x - sign(v)*max(0, n)", "n'": "-1/3"},
        {"x": 0.5, "v": 0, "n": 1},
        4.0,
        switches={"wall": "n"},
    )
    # It leaves at n = 0.5; then x'' = -x + n, until n = 0 at t = 3.
    assert t.events.t[0] == pytest.approx(1.5, abs=1e-11)
    s = 1.5
    x = 0.5 - s / 3 + (1 / 3) * math.sin(s)
    v = -1 / 3 + (1 / 3) * math.cos(s)
    assert t(3.0 - 1e-9)[:2] == pytest.approx([x, v], abs=1e-8)
    assert t(4.0)[:2] == pytest.approx(
        [x * math.cos(1) + v * math.sin(1), v * math.cos(1) - x * math.sin(1)], abs=1e-10
    )


def test_where_a_sign_carries_another_over_zero():
    """x' is 1.5 below zero, where sign(x)*y = 0.5, and 1 above it."""
    t = simulate({"x'": "1 + max(0, sign(x)*y)", "y'": "0"}, {"x": -1.5, "y": -0.5}, 2.0)
    assert t(2.0) == pytest.approx([1.0, -0.5], abs=1e-11)


def off_surface(equations, initial, u, t_end):
    """Return how far a motion that slides to the end is from its surface at most."""
    t = trajectory_of(to_yaml({**FORCED, "equations": equations, "initial": initial}), t_end)
    assert t.mode[-1].endswith("_on")
    on = np.array([mode.endswith("_on") for mode in t.mode])
    times = t.end[on] - 1e-9
    return np.max(np.abs(u(times, *t(times).T)))


@pytest.mark.parametrize(
    ("equations", "initial", "u"),
    [
        ({"x'": "v", "v'": "0.3*cos(t) - x - 2*sign(v)"}, {"x": 0.3, "v": 0.1}, lambda t, x, v: v),
        ({"x'": "v", "v'": "0.5*cos(t) - x - 2*sign(v + 0.5*x)"}, {"x": 1, "v": 0.3}, lambda t, x, v: v + 0.5 * x),
    ],
)
def test_along_a_plane_a_motion_stays_on_it_for_long(equations, initial, u):
    assert off_surface(equations, initial, u, 500.0) < 1e-14


@pytest.mark.parametrize(
    ("equations", "initial", "u"),
    [
        ({"x'": "v", "v'": "-x - 5*sign(v - 0.4*cos(t))"}, {"x": 0.2, "v": 0.3}, lambda t, x, v: v - 0.4 * np.cos(t)),
        (
            {"x'": "-v + x - 4*x*sign(x**2 + v**2 - 1)", "v'": "x + v - 4*v*sign(x**2 + v**2 - 1) + 0.5*cos(t)"},
            {"x": 1.3, "v": 0.3},
            lambda t, x, v: x**2 + v**2 - 1,
        ),
    ],
)
def test_along_a_surface_that_bends_or_moves_too(equations, initial, u):
    assert off_surface(equations, initial, u, 500.0) < 1e-13


@pytest.mark.parametrize("n", [1000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_a_motion_stays_on_a_bent_surface_that_moves(n):
    """x + y^2/4 = cos t throughout, and y = (sin t - cos t)/2; states at the beginnings of steps."""
    law = {"x'": "-3*sign(x + y**2/4 - cos(t))", "y'": "sin(t) - y"}
    end = 2 * np.pi * n
    period = {"forcing": {"period": "2*pi"}}
    t = simulate(law, {"x": 2}, end, method=Method(1e-9, 1e-11), keep_from=end - 200, **period)
    (x, y), time = t.value[1:].T, t.time[1:]
    assert np.max(np.abs(x + y**2 / 4 - np.cos(time))) < 1e-15
    assert y == pytest.approx((np.sin(time) - np.cos(time)) / 2, abs=1e-8)
