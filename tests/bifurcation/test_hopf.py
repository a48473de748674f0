"""Branches of orbits that shrink to an equilibrium end at its Hopf point."""

import math

import numpy as np
import pytest

from pddecont.tables import describe_endings
from tests.bifurcation.runs import NORMAL_FORM, SECTION, follow, settle
from tests.runs import monitor, parameter, run

LOGISTIC = {
    "name": "logistic",
    "states": ["x"],
    "parameters": {"tau": 1.8},
    "modes": {"m": {"x'": "x*(1 - x(t - tau))"}},
    "initial": {"x": 0.5},
}
TWO_DELAYS = {
    "name": "two_delays",
    "states": ["x"],
    "parameters": {"a": 1.0, "one": 1.0, "other": 1.5},
    "modes": {"m": {"x'": "-a*(x(t - one) + x(t - other))*(1 + x)"}},
    "initial": {"x": 0.3},
}
# Below the wall of the contact mode small orbits stay in the free one.
SOFT = {
    "name": "soft",
    "states": ["x", "v"],
    "parameters": {"m": 0.2, "w": 1.0},
    "modes": {"f": {"x'": "v", "v'": "m*v - x - v**3"}, "c": {"x'": "v", "v'": "m*v - x - v**3 - 3*(x - w)"}},
    "events": {"hit": "x - w"},
    "segments": {
        "in": {"mode": "f", "event": "hit", "direction": "rising", "to": "c"},
        "out": {"mode": "c", "event": "hit", "direction": "falling", "to": "f"},
    },
    "initial": {"mode": "f", "x": 0.1, "v": 0},
}
# Two oscillators: the first one's orbit r1^2 = m has a torus bifurcation where n = 1.5 m.
TWO_OSCILLATORS = {
    "name": "two_oscillators",
    "states": ["x", "y", "u", "v"],
    "parameters": {"m": 0.3, "n": 0.4},
    "modes": {
        "m": {
            "x'": "m*x - y - x*(x**2 + y**2 + 2*u**2 + 2*v**2)",
            "y'": "x + m*y - y*(x**2 + y**2 + 2*u**2 + 2*v**2)",
            "u'": "n*u - 1.7*v - u*(1.5*x**2 + 1.5*y**2 + u**2 + v**2)",
            "v'": "1.7*u + n*v - v*(1.5*x**2 + 1.5*y**2 + u**2 + v**2)",
        }
    },
    "initial": {"x": 0.5, "y": 0, "u": 0, "v": 0},
}
# A fold at m = -e^2 / 4 and the Hopf point at m = 0, a little above it.
FOLDED = {
    **NORMAL_FORM,
    "parameters": {"m": 0.1, "e": 0.05},
    "modes": {
        "m": {
            "x'": "m*x - y + e*x*(x**2 + y**2) - x*(x**2 + y**2)**2",
            "y'": "x + m*y + e*y*(x**2 + y**2) - y*(x**2 + y**2)**2",
        }
    },
}


def follow_down(path, model, name, limits, t_end=300, delay=None, **more):
    """Return the branch of a model's orbits towards smaller values of a parameter."""
    t, o = settle(t_end)
    step = follow("c", "o", {name: limits}, **{"direction": "down", "stability": True, **more})
    if delay is not None:
        o, step = ({**s, "delay": delay} for s in (o, step))
    block = {"monitors": {"amp": "amplitude(x)"}, "steps": [t, o, step]}
    return run({**model, "run": block}, path / "a.h5").step("c")


def check_end(step, name, place, period):
    """Check that a branch ends in HB1 at a place, and that none of its orbits has an amplitude of rounding errors."""
    row = step.row("HB1")
    assert parameter(step, name, "HB1") == pytest.approx(place, abs=1e-12)
    assert step.points["period"][row] == pytest.approx(period, abs=1e-11)
    assert step.points["error_estimate"][row] < 1e-12
    assert step.points["n_unstable"][row] == 0
    ordinary = step.points["kind"] != b"HB"
    amplitude = step.points["monitors"][:, step.meta["monitors"].index("amp")]
    assert amplitude[row] < 1e-14
    assert np.min(amplitude[ordinary]) > 1e-5
    assert step.points["arclength"][row] == np.min(step.points["arclength"])
    (text, *_) = describe_endings(step)
    assert text.startswith("down: the orbits shrink to an equilibrium (Hopf point")


@pytest.mark.parametrize("tau", [1.8, 1.58])
def test_the_logistic_equation_with_delay_ends_at_half_of_pi(tmp_path, tau):
    """From afar, and from an orbit of amplitude 0.2."""
    model = {**LOGISTIC, "parameters": {"tau": tau}}
    check_end(
        follow_down(tmp_path, model, "tau", [1.2, 2.1], 1500 if tau < 1.6 else 300), "tau", math.pi / 2, 2 * math.pi
    )


def test_both_directions_are_followed_and_one_ends_there(tmp_path):
    step = follow_down(tmp_path, NORMAL_FORM, "m", [-1, 1], direction="both")
    check_end(step, "m", 0.0, 2 * math.pi)
    assert sorted(label for label in step.labels if label) == ["EP1", "HB1"]


def test_a_chain_ends_at_its_own_hopf_point(tmp_path):
    """n tan(u) / cos(u)^n with n u = pi/2, and the frequency cos(u)^n."""
    n, u = 20, math.pi / 40
    step = follow_down(tmp_path, LOGISTIC, "tau", [1.2, 2.1], delay={"method": "chain", "order": 1, "n": n})
    check_end(step, "tau", n * math.tan(u) / math.cos(u) ** n, 2 * math.pi / math.cos(u) ** n)


def test_two_delays_are_both_counted(tmp_path):
    """-i w = a (exp(-i w) + exp(-1.5 i w)): 1.25 w = pi/2 and w = 2 a cos(w/4)."""
    w = math.pi / 2.5
    check_end(follow_down(tmp_path, TWO_DELAYS, "a", [0.2, 1.6]), "a", w / (2 * math.cos(w / 4)), 2 * math.pi / w)


def test_in_a_hybrid_model_the_mode_of_the_small_orbit_counts(tmp_path):
    check_end(follow_down(tmp_path, SOFT, "m", [-0.5, 0.5]), "m", 0.0, 2 * math.pi)


def test_events_that_do_nothing_hide_no_hopf_point(tmp_path):
    check_end(follow_down(tmp_path, SECTION, "m", [-0.5, 0.5]), "m", 0.0, 2 * math.pi)


def test_past_a_fold_the_branch_ends_at_the_subcritical_hopf_point(tmp_path):
    step = follow_down(tmp_path, FOLDED, "m", [-1, 1], t_end=600)
    check_end(step, "m", 0.0, 2 * math.pi)
    assert parameter(step, "m", "LP1") == pytest.approx(-(0.05**2) / 4, abs=1e-9)


def test_a_hopf_point_beyond_the_range_is_told_and_not_recorded(tmp_path):
    step = follow_down(tmp_path, NORMAL_FORM, "m", [1e-9, 1])
    assert "HB1" not in step.labels
    (text,) = describe_endings(step)
    assert "beyond the range" in text
    assert np.min(parameter(step, "m")) >= 1e-9


def test_with_other_kinds_wanted_the_branch_ends_there_without_a_label(tmp_path):
    step = follow_down(tmp_path, NORMAL_FORM, "m", [-1, 1], detect=["LP"])
    assert not any(step.labels)
    assert "Hopf point" in describe_endings(step)[0]


def test_a_curve_of_folds_ends_where_its_orbits_shrink(tmp_path):
    """m = -e^2 / 4 down to m = e = 0, where the first Lyapunov coefficient is zero."""
    model = {**FOLDED, "parameters": {"m": 0.1, "e": 0.5}}
    branch = follow("c", "o", {"m": [-1, 1]}, direction="down")
    curve = follow("lp", ("c", "LP1"), {"m": [-1, 1], "e": [-1, 1]})
    block = {"monitors": {"amp": "amplitude(x)"}, "steps": [*settle(300), branch, curve]}
    step = run({**model, "run": block}, tmp_path / "a.h5").step("lp")
    m, e = parameter(step, "m"), parameter(step, "e")
    assert np.max(np.abs(m + e**2 / 4)) < 1e-12
    assert np.max(np.abs(m + monitor(step, "amp") ** 4)) < 1e-9
    assert np.min(monitor(step, "amp")) > 1e-3
    assert not [label for label in step.labels if label and not label.startswith("EP")]
    assert "the orbits shrink to an equilibrium" in " ".join(describe_endings(step))


def test_a_torus_curve_ends_at_the_hopf_hopf_point(tmp_path):
    branch = follow("c", "o", {"n": [0, 0.6]}, stability=True)
    curve = follow("tr", ("c", "TR1"), {"m": [-1, 0.5], "n": [-1, 1]}, stability=True, direction="down")
    block = {"monitors": {"amp": "amplitude(x)"}, "steps": [*settle(200), branch, curve]}
    step = run({**TWO_OSCILLATORS, "run": block}, tmp_path / "a.h5").step("tr")
    m, n, row = parameter(step, "m"), parameter(step, "n"), step.row("HH1")
    assert np.max(np.abs(n - 1.5 * m)) < 1e-8
    assert abs(parameter(step, "m", "HH1")) < 1e-12
    assert abs(parameter(step, "n", "HH1")) < 1e-12
    assert step.points["period"][row] == pytest.approx(2 * math.pi, abs=1e-11)
    assert step.points["n_unstable"][row] == 0
    amplitude = step.points["monitors"][:, 0]
    assert np.min(amplitude[step.points["kind"] != b"HH"]) > 1e-3
    assert "(Hopf point, m = " in " ".join(describe_endings(step))
