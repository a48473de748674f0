"""Period doublings: branches that double, doubled branches that fall back, and their curves in two parameters."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.bifurcation import period_doubling
from pddecont.bifurcation.period_doubling import (
    DoublingFunction,
    compare_halves,
    find_single_orbit,
    guess_doubled_orbit,
    guess_halved_orbit,
    has_equal_halves,
)
from pddecont.collocation import MeshRule
from pddecont.continuation import CurvePoint
from pddecont.orbit import Orbit, PeriodicOrbitSystem, measure_orbit
from pddecont.orbit.residual import compute_residual
from pddecont.stability import MultiplierCache
from tests.bifurcation.runs import BALL_PD, Known, check_multipliers, make_multipliers
from tests.runs import labels, monitor, multipliers, parameter, run

BALL_SECOND_PD = 1.22177969954674


MACKEY_GLASS_PD = 1.32492152576


# Spectral collocation with step doubling, apart from this program: n of the doubling at a delay tau.
MACKEY_GLASS_CURVE = {1.5: 8.77138031192, 2.0: 7.3959269249}  # the second stands in the shared table too


def test_fold_and_doubling_of_the_ball(ball):
    step = ball.step("c")
    assert labels(step) == ["LP1", "PD1"] or labels(step) == ["PD1", "LP1"]
    assert parameter(step, "G", "LP1") == pytest.approx(math.pi * 0.2 / 1.8, abs=1e-12)
    assert parameter(step, "G", "PD1") == pytest.approx(BALL_PD, abs=1e-10)
    exact = math.sqrt(math.pi**2 * (0.2 / 1.8) ** 2 + 4 * (1 + 0.64) ** 2 / 1.8**4)
    assert exact == pytest.approx(BALL_PD, abs=1e-12)
    assert multipliers(step, step.row("PD1")) == pytest.approx([-1.0, -0.64], abs=1e-9)


def test_the_doubled_ball(ball):
    step = ball.step("twice")
    assert labels(step) == ["PD1"]
    assert parameter(step, "G", "PD1") == pytest.approx(BALL_SECOND_PD, abs=1e-9)
    assert multipliers(step, step.row("PD1")) == pytest.approx([-1.0, -(0.8**4)], abs=1e-7)
    assert step.points["period"][-1] == pytest.approx(4 * math.pi)
    assert np.all(np.diff(parameter(step, "G")) > 0)
    orbit = step.orbit(len(step) - 1)
    first, second = (orbit["states"][orbit["segment"] == s][0, 1] for s in (0, 1))
    assert abs(first - second) > 0.05


def test_mackey_glass_doubles(tmp_path):
    text = {
        "model": "mackey_glass",
        "set": {"n": 10, "tau": 1.2},
        "mesh": {"degree": 9, "tol": 1e-10},
        "steps": [
            {"name": "t", "simulate": {"t_end": 300}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {"from": "o", "free": ["tau"], "range": {"tau": [0.475, 1.5]}, "stability": True},
            },
            {
                "name": "twice",
                "continue": {
                    "from": {"step": "c", "point": "PD1"},
                    "branch": "switch",
                    "free": ["tau"],
                    "range": {"tau": [1, 1.5]},
                    "stability": True,
                },
            },
        ],
    }
    results = run(text, tmp_path / "a.h5")
    step, twice = results.step("c"), results.step("twice")
    assert labels(step) == ["PD1"]
    assert parameter(step, "tau", "PD1") == pytest.approx(MACKEY_GLASS_PD, abs=1e-9)
    assert step.points["period"][step.row("PD1")] == pytest.approx(3.9196496081, abs=1e-9)
    # The orbit is born at the Hopf point tau = .4708196289 with period 2 pi / Im; near it the amplitude grows as a
    # square root.
    assert step.points["trivial_error"].max() < 1e-8
    assert twice.points["period"][1] == pytest.approx(2 * 3.9196496081, rel=0.02)
    assert np.all(twice.points["stable"][1:] == 1)
    assert np.all(np.diff(parameter(twice, "tau")) > 0)


def test_the_doubling_met_from_the_doubled_side(fig4_7):
    """Contact time and multipliers of the period-1 orbit at its doubling, from shooting with matrix exponentials."""
    step = fig4_7.step("c")
    assert monitor(step, "contact_time", "PD1") == pytest.approx(0.091210359937, abs=1e-9)
    assert multipliers(step, step.row("PD1"))[:3] == pytest.approx([-1.0, -0.24105926, 0.03017588], abs=1e-7)
    assert monitor(step, "x_max", "VS1") == pytest.approx(1.26, abs=1e-12)


def test_doublings_of_the_ball(ball, tmp_path):
    step = ball.step("pd")
    assert step.meta["curve"] == "PD"
    G, r = parameter(step, "G"), parameter(step, "r")
    exact = np.sqrt(math.pi**2 * ((1 - r) / (1 + r)) ** 2 + 4 * (1 + r**2) ** 2 / (1 + r) ** 4)
    assert exact == pytest.approx(G, abs=1e-9)
    assert len(step) > 15
    check_multipliers(ball, "pd", "bouncing_ball", tmp_path, every=4)


def test_doublings_of_mackey_glass(tmp_path):
    text = {
        "model": "mackey_glass",
        "set": {"n": 10, "tau": 1.2},
        "mesh": {"degree": 9, "tol": 1e-10},
        "steps": [
            {"name": "t", "simulate": {"t_end": 300}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["tau"],
                    "range": {"tau": [1, 1.5]},
                    "stability": True,
                    "direction": "up",
                },
            },
            {
                "name": "a",
                "continue": {
                    "from": {"step": "c", "point": "PD1"},
                    "free": ["tau", "n"],
                    "range": {"tau": [1.3, 1.5], "n": [4, 12]},
                    "direction": "up",
                },
            },
            {
                "name": "pd",
                "continue": {
                    "from": {"step": "c", "point": "PD1"},
                    "free": ["tau", "n"],
                    "range": {"tau": [1.3, 2.0], "n": [4, 12]},
                    "direction": "up",
                    "stability": True,
                },
            },
        ],
    }
    results = run(text, tmp_path / "a.h5")
    for name, tau in (("a", 1.5), ("pd", 2.0)):
        step = results.step(name)
        assert parameter(step, "tau", "EP1") == pytest.approx(tau, abs=1e-12)
        assert parameter(step, "n", "EP1") == pytest.approx(MACKEY_GLASS_CURVE[tau], abs=1e-8)
    check_multipliers(results, "pd", "mackey_glass", tmp_path, every=2)


RULE = MeshRule(8, tol=1e-9)


def scaling_of(orbit):
    return PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit)).scaling


@pytest.mark.parametrize("name", ["hop_orbit", "soft_orbit", "free_orbit"])
def test_an_orbit_taken_twice_is_one_with_equal_halves(name, request):
    orbit = request.getfixturevalue(name)
    twice = guess_doubled_orbit(orbit, RULE)[0]
    assert twice.period == pytest.approx(2 * orbit.period, rel=1e-14)
    assert twice.problem.n_periods == 2 * orbit.problem.n_periods
    assert len(twice.signature) == (2 * len(orbit.signature) if orbit.signature.has_events else 1)
    assert has_equal_halves(twice, scaling_of(twice))
    assert np.max(np.abs(compute_residual(twice))) < 1e-6


@pytest.mark.parametrize("name", ["hop_orbit", "free_orbit"])
def test_in_the_direction_of_the_doubled_orbits_the_halves_come_to_differ(name, request):
    """One way or the other."""
    twice, direction = guess_doubled_orbit(request.getfixturevalue(name), RULE)
    apart = [Orbit(twice.problem, twice.x + k * direction) for k in (-1e-2, 1e-2)]
    one, other = (compare_halves(orbit, scaling_of(twice)) for orbit in apart)
    assert np.max(np.abs(one)) > 1e-4
    assert one == pytest.approx(-other, abs=1e-6)
    assert not any(has_equal_halves(orbit, scaling_of(twice)) for orbit in apart)


@pytest.mark.parametrize("name", ["hop_orbit", "soft_orbit", "free_orbit"])
def test_the_mean_of_both_halves_is_the_single_orbit(name, request):
    """What the doubled orbit adds to one half it takes from the other."""
    orbit = request.getfixturevalue(name)
    twice, _ = guess_doubled_orbit(orbit, RULE)
    # Shifted by a period, this perturbation has the other sign.
    times, unknowns, x = twice.mesh.base_times(twice.theta), twice.problem.unknowns, twice.x.copy()
    x[unknowns.values] += 1e-3 * np.repeat(np.cos(math.pi * times / orbit.period), 2)
    single = guess_halved_orbit(Orbit(twice.problem, x), RULE)
    assert single.signature.names == orbit.signature.names
    assert single.problem.n_periods == orbit.problem.n_periods
    assert single.durations == pytest.approx(orbit.durations, rel=1e-12)
    inside = np.linspace(0.01, 0.99, 25) * orbit.period
    found, expected = (o.mesh.interpolate(o.values, o.mesh.locate(o.theta, inside)[0]) for o in (single, orbit))
    assert found == pytest.approx(expected, abs=1e-6)


def test_what_cannot_be_an_orbit_taken_twice_has_no_halves(hop_orbit, soft_orbit):
    """One forcing period cannot be halved, nor can the segments [NC C] over two."""
    for orbit in (hop_orbit, soft_orbit):
        assert len(compare_halves(orbit, scaling_of(orbit))) == 0
        assert not has_equal_halves(orbit, scaling_of(orbit))


def test_a_branch_that_stays_apart_from_the_single_orbit_meets_none(hop_orbit):
    twice, direction = guess_doubled_orbit(hop_orbit, RULE)
    system = PeriodicOrbitSystem(twice.problem, measure_orbit(twice))
    near, far = (CurvePoint(system, system.at(twice.x + k * direction)) for k in (1e-2, 2e-2))
    assert find_single_orbit(near, far, RULE, MultiplierCache()) is None


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=5))
def test_the_test_function_is_the_distance_to_minus_one_and_counts_those_beyond(real):
    value = period_doubling.measure_distance(make_multipliers([*real, 1j, -1j]))
    assert abs(value) == min(abs(v + 1.0) for v in real)
    if value:
        assert np.sign(value) == (-1.0) ** sum(v < -1.0 for v in real)


def test_without_a_real_multiplier_there_is_no_test_function():
    assert math.isnan(period_doubling.measure_distance(make_multipliers([1j, -1j])))


def test_the_defining_function_stays_smooth_where_multipliers_meet_near_minus_one():
    """The product of 1 + mu over all that are near: real for a pair, and no root of it."""
    values = [-1.1 + 0.1j, -1.1 - 0.1j, 0.5]
    at = SimpleNamespace(orbit=None)
    function = DoublingFunction(Known(values)).update_at(at)
    assert function.n == 2
    assert function.evaluate(at) == pytest.approx(0.1**2 + 0.1**2, abs=1e-15)
    assert DoublingFunction(Known([0.5, -0.2]), 3).update_at(at).n == 1
    assert DoublingFunction(Known([0.5, -0.2])).evaluate(at) == pytest.approx(0.8, abs=1e-15)
    assert math.isnan(DoublingFunction(Known([])).evaluate(at))
