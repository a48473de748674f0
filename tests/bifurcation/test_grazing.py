"""Grazings of orbits, and their curves in two parameters against closed forms."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from pddecont.bifurcation import BranchSettings, StartError, find_kind, measure_grazing_gap, start_curve
from pddecont.bifurcation.grazing import GrazingFunction, define_grazing
from pddecont.bifurcation.period_doubling import guess_doubled_orbit
from pddecont.collocation import MeshRule
from pddecont.continuation import End
from pddecont.errors import ConvergenceError
from pddecont.orbit import PeriodicOrbitSystem, measure_orbit
from pddecont.reasons import NO_REASON
from pddecont.tables import describe_endings, make_table
from tests.bifurcation.runs import check_multipliers, free_amplitude
from tests.problems import grazing_amplitude
from tests.runs import add_step, labels, parameter, run


def test_the_grazing_curve_of_the_free_orbit_is_the_closed_form(fig4_8, tmp_path):
    step = fig4_8.step("one")
    K, tau = parameter(step, "K"), parameter(step, "tau_d")
    assert len(step) > 15
    assert np.max(tau) == 7.4 and np.min(tau) < 2.3
    amplitudes = [grazing_amplitude(k, np.exp(-0.8j * t)) for k, t in zip(K, tau, strict=True)]
    assert amplitudes == pytest.approx([1.26] * len(K), abs=1e-10)
    for k, t in zip(K[:: len(K) // 12], tau[:: len(K) // 12], strict=True):
        exact = brentq(lambda k, t=t: grazing_amplitude(k, np.exp(-0.8j * t)) - 1.26, k - 0.01, k + 0.01, xtol=1e-15)
        assert k == pytest.approx(exact, abs=1e-9)
    check_multipliers(fig4_8, "one", "impact_oscillator", tmp_path, every=8)


def test_the_grazing_curve_of_the_impacting_orbit(fig4_8, tmp_path):
    step = fig4_8.step("gr")
    assert step.meta["curve"] == "GR"
    assert np.all(step.points["admissible"] == 1)
    K, tau = parameter(step, "K"), parameter(step, "tau_d")
    # It passes the grazings that were found in one parameter: K = 0.12 at tau_d = 3.2164416411 lies on it.
    i = int(np.argmin(np.abs(tau - 3.2164)))
    near = np.argsort(np.abs(tau - tau[i]))[:5]
    assert np.polynomial.Polynomial.fit(tau[near], K[near], 4)(3.2164416411) == pytest.approx(0.12, abs=1e-5)
    check_multipliers(fig4_8, "gr", "impact_oscillator", tmp_path, every=9)
    # The side without a third contact lies below the curve here: K smaller.
    inner = [j for j in range(len(step)) if np.isfinite(step.points["side"][j]).all()]
    assert len(inner) == len(step)
    assert np.all(step.points["side"][step.order][(tau > 3.5) & (tau < 3.7), 1] < 0)


TWO_WALLS = {
    "name": "two_walls",
    "states": ["x", "v"],
    "parameters": {"omega": 2.6, "a": 0.3, "b": 0.35, "c": 0.1, "r": 0.8},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v - x"}},
    "events": {"right": "x - a", "left": "x + b"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {
        "right": {"mode": "free", "event": "right", "direction": "rising", "reset": "bounce", "to": "free"},
        "left": {"mode": "free", "event": "left", "direction": "falling", "reset": "bounce", "to": "free"},
    },
    "run": {
        "mesh": {"degree": 9, "tol": 1e-11},
        "monitors": {"top": "max(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 200}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["omega"],
                    "range": {"omega": [1.7, 2.7]},
                    "direction": "down",
                    "signature_change": "stop",
                    "events_along": {"level": "top - 0.25"},
                },
            },
            {
                "name": "gr",
                "continue": {
                    "from": {"step": "c", "point": "GR1"},
                    "free": ["omega", "a"],
                    "range": {"omega": [1.7, 2.7], "a": [0.2, 0.5]},
                },
            },
            {
                "name": "uf",
                "continue": {
                    "from": {"step": "c", "point": "UF1"},
                    "free": ["omega", "c"],
                    "range": {"omega": [1.7, 2.7], "c": [0.01, 0.5]},
                    "events_along": {"level": "top - 0.25"},
                },
            },
        ],
    },
}


@pytest.mark.parametrize("direction", ["both", "down"])
def test_where_two_grazings_meet_the_curve_of_the_other_goes_on(tmp_path, direction):
    """At the left wall the free orbit, of amplitude A(w), grazes where A = 0.35, whatever a is; beyond a = 0.35 alone
    nothing else is hit.
    """
    other = {
        "name": "other",
        "continue": {
            "from": {"step": "gr", "point": "GG1"},
            "free": ["omega", "a"],
            "range": {"omega": [1.7, 2.7], "a": [0.2, 0.5]},
            "direction": direction,
        },
    }
    results = run(add_step(TWO_WALLS, other), tmp_path / "a.h5")
    step = results.step("other")
    a, omega = parameter(step, "a"), parameter(step, "omega")
    assert step.meta["curve"] == "GR"
    assert 1 / np.hypot(1 - omega**2, 0.1 * omega) == pytest.approx(0.35, abs=1e-10)
    assert min(a) == pytest.approx(0.35, abs=1e-10) and max(a) == pytest.approx(0.5, abs=1e-12)
    assert len(step.endings) == 1
    assert np.all(step.points["admissible"] == 1)
    assert labels(step) == []
    (found,) = [row for row in make_table(results.step("gr"), "special") if row["label"] == "GG1"]
    assert found["note"] == "left and right"


def test_a_double_grazing_that_does_not_say_what_grazes_starts_no_curve(far_orbit):
    """Files of versions before this one kept no more than the label."""
    with pytest.raises(StartError, match="does not say what grazes there"):
        start_curve(far_orbit, "GG", NO_REASON, BranchSettings(("a",), ((0.0, 1.0),), MeshRule(8)), ("GR", NO_REASON))


def test_double_grazing_and_a_user_function(tmp_path):
    """The free orbit has amplitude A(w); it touches the right wall where A = a, both where a = b = A; A = 1/4 is the
    user's own curve.
    """

    results = run(TWO_WALLS, tmp_path / "a.h5")
    step = results.step("gr")
    a, omega = parameter(step, "a"), parameter(step, "omega")
    assert 1 / np.hypot(1 - omega**2, 0.1 * omega) == pytest.approx(a, abs=1e-10)
    assert labels(step) == ["GG1"]
    assert parameter(step, "a", "GG1") == pytest.approx(0.35, abs=1e-10)
    beyond = a > 0.35 + 1e-6
    assert np.any(beyond)
    assert np.all(step.points["admissible"][step.order][beyond] == 0)
    assert np.all(step.points["admissible"][step.order][a < 0.35 - 1e-6] == 1)
    user = results.step("uf")
    assert user.meta["curve"] == "UF"
    omega, c = parameter(user, "omega"), parameter(user, "c")
    assert 1 / np.hypot(1 - omega**2, c * omega) == pytest.approx(0.25, abs=1e-10)
    assert len(user) > 10


@pytest.mark.parametrize(("degree", "intervals"), [(7, 12), (7, 24), (8, 24), (6, 16)])
def test_an_extremum_on_an_edge_of_the_mesh_is_seen(tmp_path, degree, intervals):
    """The pulse's sin(2 pi t) has its minimum at an edge; missed, its rise at the end would look like a fall."""
    text = {
        "model": "pulsed_control",
        "mesh": {"degree": degree, "intervals": intervals},
        "steps": [
            {"name": "t", "simulate": {"t_end": 150}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["b"], "range": {"b": [-2, -0.5]}}},
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    assert np.all(step.points["admissible"] == 1)
    assert all("reached the end of the range" in t for t in describe_endings(step))


def system_at(orbit):
    return PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit)).at(orbit.x)


def test_the_gap_is_what_is_left_before_the_wall(far_orbit):
    """Negative for an admissible orbit: the amplitude less the wall's distance."""
    assert measure_grazing_gap(far_orbit) == pytest.approx(free_amplitude(2.0) - 0.5, abs=1e-8)


def test_an_orbit_that_watches_nothing_grazes_nothing(free_orbit):
    assert math.isnan(measure_grazing_gap(free_orbit))
    assert define_grazing(free_orbit) is None
    with pytest.raises(ConvergenceError, match="no event function has an extremum inside a segment on this mesh"):
        find_kind("GR").define(system_at(free_orbit), None, NO_REASON)


def test_the_grazing_of_an_orbit_is_its_closest_approach(far_orbit):
    """x = A cos(2 t - phase) has its maximum once a period, whose value the function is."""
    found = define_grazing(far_orbit)
    assert (found.event, found.segment, found.is_max, found.kind) == ("hit", 0, True, "GR")
    phase = np.angle(1 / (1 - 4.0 + 0.2j))
    top = (-phase / 2 - far_orbit.start) % math.pi / math.pi
    assert found.fraction == pytest.approx(top, abs=1e-7)
    assert found.evaluate(system_at(far_orbit)) == measure_grazing_gap(far_orbit)
    # Nothing else comes near, and this one does not count twice.
    assert found.find_other(far_orbit) is None
    assert find_kind("GR").good_side(found) == -1.0


@pytest.mark.parametrize("away", [0.02, -0.02, 1.0 - 1e-3])
def test_an_extremum_is_found_again_where_it_has_moved_to(far_orbit, away):
    """Along a closed orbit fractions 0 and 1 are the same place."""
    at, found = system_at(far_orbit), define_grazing(far_orbit)
    moved = replace(found, fraction=(found.fraction + away) % 1.0)
    assert moved.update_at(at).fraction == pytest.approx(found.fraction, abs=1e-12)
    assert moved.evaluate(at) == found.evaluate(at)


def test_of_two_extrema_the_nearest_round_the_orbit_is_meant(far_orbit):
    """The orbit taken twice has its maximum twice, half of it apart."""
    twice = guess_doubled_orbit(far_orbit, MeshRule(8, tol=1e-9))[0]
    at, first = system_at(twice), 0.5 * define_grazing(far_orbit).fraction
    for fraction in (first, first + 0.5):
        for away in np.linspace(-0.2475, 0.2475, 9):
            meant = GrazingFunction("hit", 0, (fraction + away) % 1.0, True)
            assert meant.update_at(at).fraction == pytest.approx(fraction, abs=1e-6)


def test_an_extremum_of_the_other_kind_is_another(far_orbit):
    at, found = system_at(far_orbit), define_grazing(far_orbit)
    low = replace(found, is_max=False)
    assert low.evaluate(at) == pytest.approx(-free_amplitude(2.0) - 0.5, abs=1e-8)
    assert find_kind("GR").good_side(low) == 1.0
    elsewhere = GrazingFunction("hit", 1, 0.5, True)
    extended = replace(elsewhere, segment=0)
    assert extended.evaluate(at) == found.evaluate(at)


def test_along_a_branch_each_segment_and_event_has_its_own_test(soft_orbit):
    """Free flight watches the impact rising, contact watches it falling; the free peak is the only one that is near."""
    settings = BranchSettings(("tau_d",), ((3, 5),), MeshRule(8, tol=1e-9))
    at = system_at(soft_orbit)
    tests = find_kind("GR").branch_tests(at, settings)
    assert [test.kind for test in tests] == ["GR", "GR"] and all(test.end == End.SPECIAL for test in tests)
    values = [test.value(SimpleNamespace(at=at)) for test in tests]
    assert values[0] == pytest.approx(measure_grazing_gap(soft_orbit), abs=1e-15) and values[0] < 0.0
    # Contact has a maximum alone, which lies away from its surface.
    assert math.isnan(values[1])
