"""Orbits of the delay equation itself, against closed forms and independent numbers."""

import math

import numpy as np
import pytest

from benchmarks import tracking
from benchmarks.tracking import errors_on_refinement
from pddecont.collocation import Mesh, MeshRule, equal_cuts
from pddecont.continuation import NewtonSettings, correct_component
from pddecont.delay import Chebyshev, Direct
from pddecont.orbit import (
    Orbit,
    OrbitProblem,
    PeriodicOrbitSystem,
    Signature,
    adapt_mesh,
    estimate_error,
    make_eventless,
    measure_orbit,
    solve_orbit,
)
from pddecont.tables import describe_endings, describe_reason, make_table
from tests.conftest import numeric_from
from tests.orbits import segment_pieces
from tests.problems import IMPACT_SPEED, MACKEY_GLASS_PD, WRIGHT, neuron, on_off, relay, turning
from tests.runs import change, run

FINE = {"degree": 10, "tol": 1e-12}


def start(t_end, **more):
    """Return the steps that find an orbit."""
    return [{"name": "t", "simulate": {"t_end": t_end, **more}}, {"name": "o", "orbit": {"from": "t"}}]


def orbit(model, changes, path, t_end=80, mesh=FINE, monitors=None, delay="direct"):
    """Return the row of an orbit as a dictionary."""
    keys = {"set": changes, "mesh": mesh, "delay": {"method": delay}, "monitors": monitors or {}}
    step = run({"model": model, **keys, "steps": start(t_end)}, path / "a.h5").step("o")
    return make_table(step, "points")[0]


@pytest.fixture(scope="module")
def impact():
    """The impact oscillator's orbit on a fine mesh."""
    return tracking.soft()


@pytest.fixture(scope="module")
def wall():
    """The same for a hard wall with delayed feedback."""
    return tracking.hard()


def speed(orbit):
    return orbit.values[orbit.mesh.last_base[0], 1]


def on_rule(orbit, rule):
    """Return an orbit solved again on meshes of another rule."""
    return solve_orbit(adapt_mesh(orbit, rule), rule).at.orbit


def test_impact_speed_with_few_unknowns(impact):
    coarse = on_rule(impact, MeshRule(9, intervals=20))
    assert len(coarse.x) < 450
    assert speed(coarse) == pytest.approx(IMPACT_SPEED, abs=1e-10)
    assert speed(impact) == pytest.approx(IMPACT_SPEED, abs=1e-12)


def errors_of(found):
    return [error for _, error in found]


@pytest.mark.parametrize("degree", [3, 4, 5])
def test_order_with_tracked_breaking_points(impact, degree):
    errors = errors_of(errors_on_refinement(impact, degree, True, (1, 2, 4)))
    orders = -np.diff(np.log2(errors))
    assert orders[-1] > degree + 0.6
    assert np.log2(errors[0] / errors[-1]) / 2 > degree + 0.5


def test_order_after_a_jump_with_tracked_breaking_points(wall):
    errors = errors_of(errors_on_refinement(wall, 4, True, (1, 2, 4)))
    assert np.log2(errors[0] / errors[-1]) / 2 == pytest.approx(5, abs=0.3)
    assert errors_of(errors_on_refinement(wall, 4, False, (32,)))[0] > 1e3 * errors[-1]


def test_order_without_tracking_is_about_three(impact):
    errors = errors_of(errors_on_refinement(impact, 6, False, (10, 20, 40, 80)))
    order = np.log2(errors[0] / errors[-1]) / 3
    assert 1.8 < order < 3.6
    assert errors[-1] > 1e-8


@pytest.mark.parametrize(("degree", "intervals"), [(2, 2), (4, 5), (7, 3)])
def test_relay_of_straight_pieces_is_exact_on_any_mesh(tmp_path, degree, intervals):
    row = orbit(
        "relay", {"a": 0, "tau": 0.7}, tmp_path, 40, {"degree": degree, "intervals": intervals}, {"amp": "amplitude(x)"}
    )
    assert row["period"] == pytest.approx(2.8, abs=1e-12)
    assert row["amp"] == pytest.approx(0.7, abs=1e-12)


@pytest.mark.parametrize(("a", "tau"), [(0.5, 1.0), (-0.7, 1.3), (0.2, 2.0)])
def test_relay(tmp_path, a, tau):
    row = orbit("relay", {"a": a, "tau": tau}, tmp_path, 80 * tau, monitors={"amp": "amplitude(x)"})
    assert (row["period"], row["amp"]) == pytest.approx(relay(a, tau), abs=1e-11)


@pytest.mark.parametrize("tau", [0.8, 2.5])
def test_on_off_control(tmp_path, tau):
    row = orbit("on_off_control", {"tau": tau}, tmp_path, 60, monitors={"high": "max(x)", "low": "min(x)"})
    assert (row["period"], row["high"], row["low"]) == pytest.approx(on_off(1.5, 0, 1, tau), abs=1e-11)


def test_wright(tmp_path):
    row = orbit("wright", {}, tmp_path, 150, monitors={"high": "max(x)"})
    assert row["period"] == pytest.approx(WRIGHT["period"], abs=1e-9)
    assert row["high"] == pytest.approx(WRIGHT["highest"], abs=1e-9)


def test_mackey_glass_at_its_period_doubling(tmp_path):
    """Past the doubling simulations go elsewhere, so the orbit comes from before it."""
    branch = {"from": "o", "free": ["tau"], "range": {"tau": [0.9, MACKEY_GLASS_PD["tau"]]}, "direction": "up"}
    steps = [*start(200), {"name": "c", "continue": branch}]
    step = run({"model": "mackey_glass", "mesh": FINE, "steps": steps}, tmp_path / "a.h5").step("c")
    assert step.points["period"][step.row("EP1")] == pytest.approx(MACKEY_GLASS_PD["period"], abs=1e-9)


def test_turning_at_the_lobes_lowest_point():
    """The linear equation has orbits of any size exactly on the lobe: with the size given, width of cut and period come
    out.
    """
    numeric = numeric_from(
        "name: turning\nstates: [x, v]\nparameters: {zeta: 0.02, w: 0.05, tau: 1}\n"
        "modes: {cut: {x': v, v': -2*zeta*v - x - w*(x - x(t - tau))}}\n"
    )
    W = math.sqrt(1 + 2 * 0.02)
    w, tau = turning(0.02, W)
    assert (w, tau) == pytest.approx((0.0408, 4.6401058748), abs=1e-10)
    mesh = Mesh(10, 1, segment_pieces(1, 2, equal_cuts([12])))
    T = 2 * math.pi / W
    times = mesh.base_times(np.array([T, tau]))
    values = np.stack([np.cos(W * times), -W * np.sin(W * times)], 1)
    p = np.array([0.02, 0.05, tau])
    signature = Signature(numeric, (make_eventless(numeric.model, "cut"),))
    problem = OrbitProblem(signature, mesh, Direct(), p, ("w",), 1, values)
    guess = Orbit(problem, problem.unknowns.join(values, [T * 1.001], 0.0, [0.0401]))
    system = PeriodicOrbitSystem(problem, measure_orbit(guess, (1.0,)))
    found = correct_component(system, guess.x, 0, 1.0, NewtonSettings()).at.orbit
    assert found.free[0] == pytest.approx(w, abs=1e-9)
    assert found.period == pytest.approx(T, abs=1e-9)


@pytest.mark.parametrize("tau", [0.4, 0.95, 2.3, 7.1])
def test_delayed_kicks_of_which_many_are_under_way(tmp_path, tau):
    row = orbit("spiking_neuron", {"tau": tau}, tmp_path, 200)
    assert row["period"] == pytest.approx(neuron(1.5, -0.1, tau), abs=1e-11)


def test_kicks_followed_in_their_delay(tmp_path):
    """The kick must come before the next spike would; the branch ends where the two meet and says so."""
    branch = {"from": "o", "free": ["tau"], "range": {"tau": [0.2, 2]}, "direction": "up"}
    steps = [*start(60), {"name": "c", "continue": branch}]
    step = run({"model": "spiking_neuron", "mesh": FINE, "steps": steps}, tmp_path / "a.h5").step("c")
    taus = step.points["parameters"][:, step.meta["parameters"].index("tau")]
    for tau, period in zip(taus, step.points["period"], strict=True):
        if tau < 0.9:
            assert period == pytest.approx(neuron(1.5, -0.1, tau), abs=1e-10)
    assert describe_endings(step)[0].startswith("up: stopped at a special point")
    assert describe_reason(step.reason(step.row("VS1"))).endswith("meets spike")


def test_several_delays_in_one_equation(tmp_path):
    """x'' + 0.2 x' + x = 0.3 x(t - 1) - 0.2 v(t - 2.5) + cos(1.1 t): a complex amplitude solves it."""
    text = {
        "name": "m",
        "states": ["x", "v"],
        "parameters": {"w": 1.1, "t1": 1, "t2": 2.5, "t3": 90},
        "forcing": {"period": "2*pi/w"},
        "modes": {"m": {"x'": "v", "v'": "cos(w*t) - 0.2*v - x + 0.3*x(t - t1) - 0.2*v(t - t2) + 0.05*x(t - t1 - t3)"}},
        "run": {
            "mesh": {"degree": 10, "tol": 1e-12},
            "monitors": {"amp": "amplitude(x)"},
            "steps": [{"name": "t", "simulate": {"t_end": 900}}, {"name": "o", "orbit": {"from": "t"}}],
        },
    }
    step = run(text, tmp_path / "a.h5").step("o")
    w = 1.1
    amplitude = abs(
        1 / (1 - w**2 + 0.2j * w - 0.3 * np.exp(-1j * w) + 0.2j * w * np.exp(-2.5j * w) - 0.05 * np.exp(-91j * w))
    )
    assert step.points["monitors"][0, 0] == pytest.approx(amplitude, rel=1e-10)


@pytest.mark.parametrize(("n", "error"), [(6, 1e-3), (9, 1e-6), (12, 1e-9)])
def test_the_chebyshev_line_converges_fast_on_a_smooth_orbit(n, error):
    mesh = Mesh(9, 1, segment_pieces(1, 2, equal_cuts([14])))
    theta = np.array([2 * math.pi / 0.8, 3.8])
    u = np.sin(0.8 * mesh.base_times(theta))[:, None]
    values = Chebyshev(n).operator(mesh, theta, np.array([0.0, 1.0]), mesh.equation_points).weights.apply(u)[:, 0]
    worst = np.max(np.abs(values - np.sin(0.8 * (mesh.equation_times @ theta - 3.8))))
    assert worst < error


@pytest.mark.parametrize("tol", [1e-4, 1e-6, 1e-8])
def test_the_estimate_tells_the_error(impact, tol):
    found = on_rule(impact, MeshRule(6, tol=tol))
    estimate = estimate_error(found)
    assert estimate <= tol
    assert abs(speed(found) - IMPACT_SPEED) < 2 * estimate


@pytest.mark.parametrize("turns", [1, 2])
def test_a_delay_of_exactly_so_many_periods(tmp_path, turns):
    """Breaking points collide exactly. After two forcing periods, the orbit's own, the feedback is zero: K does not
    matter.
    """
    text = {
        "model": "impact_oscillator",
        "mesh": {"degree": 9, "tol": 1e-11},
        "monitors": {"v": "at(NC, v)"},
        "steps": [
            {"name": "t", "set": {"K": 0}, "simulate": {"t_end": "250*2*pi/omega"}},
            {"name": "plain", "set": {"K": 0}, "orbit": {"from": "t"}},
            {"name": "held", "set": {"K": 0.05, "tau_d": f"{turns}*2*pi/omega"}, "orbit": {"from": "plain"}},
        ],
    }
    results = run(text, tmp_path / "a.h5")
    plain, held = (results.step(name).points["monitors"][0, 0] for name in ("plain", "held"))
    if turns == 2:
        assert held == pytest.approx(plain, abs=1e-10)
    else:
        # The half period reads the orbit's other loop: another orbit, the same on another mesh.
        other = run(change(text, "mesh", {"degree": 7, "tol": 1e-10}), tmp_path / "b.h5")
        assert abs(held - plain) > 1e-3
        assert other.step("held").points["monitors"][0, 0] == pytest.approx(held, abs=1e-8)


def test_the_delay_can_be_zero(tmp_path):
    """Followed down to tau = 0 the orbit becomes that of the equation without delay."""
    text = {
        "model": "van_der_pol",
        "mesh": {"degree": 10, "tol": 1e-12},
        "steps": [
            {"name": "t", "simulate": {"t_end": 120}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["tau"], "range": {"tau": [0, 2]}, "direction": "down"}},
            {"name": "t0", "set": {"tau": 0}, "simulate": {"t_end": 120}},
            {"name": "o0", "set": {"tau": 0}, "orbit": {"from": "t0"}},
        ],
    }
    results = run(text, tmp_path / "a.h5")
    followed = results.step("c")
    assert followed.points["period"][followed.row("EP1")] == pytest.approx(
        results.step("o0").points["period"][0], abs=1e-9
    )


def test_a_reset_that_reads_a_delayed_state_never_reads_across_its_jump(tmp_path):
    """x' = 1 - x, at x = 0.8 to q x(t - tau). While tau < T: x0 = q (1 - (1 - x0) exp(tau - T)), T = ln((1 - x0) /
    0.2).

    At tau = T the delayed value jumps, and the branch ends there instead of going on with a value from the wrong side.
    """
    text = {
        "name": "m",
        "states": ["x"],
        "parameters": {"tau": 0.5, "q": 0.3},
        "modes": {"m": {"x'": "1 - x"}},
        "events": {"hit": "x - 0.8"},
        "resets": {"j": {"x": "q*x(t - tau)"}},
        "segments": {"s": {"mode": "m", "event": "hit", "direction": "rising", "reset": "j", "to": "m"}},
        "initial": {"x": 0.1},
        "run": {
            "mesh": {"degree": 8, "tol": 1e-11},
            "monitors": {"x0": "min(x)"},
            "steps": [
                {"name": "t", "simulate": {"t_end": 60}},
                {"name": "o", "orbit": {"from": "t"}},
                {"name": "c", "continue": {"from": "o", "free": ["tau"], "range": {"tau": [0.1, 6]}}},
            ],
        },
    }
    step = run(text, tmp_path / "a.h5").step("c")
    assert "across a jump" in describe_endings(step)[1] or "too sharply" in describe_endings(step)[1]
    for (tau, q), T, (x0,) in zip(
        step.points["parameters"], step.points["period"], step.points["monitors"], strict=True
    ):
        assert tau < T
        assert math.log((1 - x0) / 0.2) == pytest.approx(T, abs=1e-9)
        assert q * (1 - (1 - x0) * math.exp(tau - T)) == pytest.approx(x0, abs=1e-9)
    assert step.points["parameters"][:, 0].max() == pytest.approx(math.log(5), abs=1e-3)
