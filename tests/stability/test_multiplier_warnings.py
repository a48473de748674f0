"""What lists of multipliers cannot be trusted with is said beside them."""

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.delay import Chain
from pddecont.errors import ConvergenceError
from pddecont.orbit.examination import Examination
from pddecont.results import read_results
from pddecont.stability import candidates as module_of_candidates
from pddecont.stability import find_multipliers
from pddecont.stability import multipliers as module_of_multipliers
from pddecont.stability.characteristic import MapCharacteristic
from pddecont.stability.refinement import refine
from pddecont.tables import describe_done, describe_endings, make_table, summarise_step
from tests.known_orbits import impact_oscillator
from tests.orbits import settle_to_orbit
from tests.runs import change, run
from tests.stability.test_multipliers import nontrivial, with_delay


def test_a_poor_mesh_shows_in_the_trivial_multiplier_and_is_warned_of(tmp_path):
    mapping = {
        "model": "van_der_pol",
        "mesh": {"degree": 3, "intervals": 8},
        "steps": [{"name": "t", "simulate": {"t_end": 60}}, {"name": "o", "orbit": {"from": "t", "stability": True}}],
    }
    errors = []
    for n in (8, 40):
        step = run(change(mapping, "mesh.intervals", n), tmp_path / "a.h5").step("o")
        errors.append(step.points["trivial_error"][0])
        ending = describe_endings(step)[0].split("trivial multiplier")[1]
        assert ("WARNING" in ending) == (errors[-1] > 1e-4)
        assert ("warning" in summarise_step(step)) == (errors[-1] > 1e-4)
    assert errors[0] > 1e-3
    assert errors[1] < 1e-4


def test_a_jump_that_comes_back_at_its_own_event_is_warned_of(tmp_path):
    """Delayed feedback over exactly one period of a bouncing orbit: the multipliers differ on either side of it."""
    model = {
        "name": "pyragas",
        "states": ["x", "v"],
        "parameters": {"omega": 2, "c": 0.1, "wall": 0.2, "r": 0.8, "K": 0.2, "f": 1},
        "forcing": {"period": "2*pi/omega"},
        "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v - x + K*(v(t - f*2*pi/omega) - v)"}},
        "events": {"hit": "x - wall"},
        "resets": {"bounce": {"v": "-r*v"}},
        "segments": {
            "flight": {"mode": "free", "event": "hit", "direction": "rising", "reset": "bounce", "to": "free"}
        },
        "run": {
            "mesh": {"degree": 8, "tol": 1e-09},
            "steps": [
                {"name": "t", "simulate": {"t_end": 300}},
                {"name": "o", "orbit": {"from": "t", "stability": True}},
            ],
        },
    }
    found = {}
    for factor in (1 - 1e-6, 1, 1 + 1e-6):
        step = run(change(model, "parameters.f", factor), tmp_path / "a.h5").step("o")
        found[factor] = describe_endings(step)[0]
    assert "comes back through a delay just at an event" in found[1]
    assert not any("comes back" in found[factor] for factor in (1 - 1e-6, 1 + 1e-6))


def test_multipliers_of_a_lines_own_stages_are_left_out_or_said_to_hide_the_orbits():
    """Stages far shorter than mesh intervals ring on in the collocated line: what depends on the mesh is no multiplier
    of the orbit.
    """
    orbit = settle_to_orbit("van_der_pol", t_end=80)
    rule = MeshRule(8, intervals=30)
    direct = nontrivial(orbit, 2)
    seen = {}
    for order, n in ((2, 60), (3, 60), (3, 200)):
        seen[order, n] = find_multipliers(with_delay(orbit, Chain(order, n), rule), 6)
        assert seen[order, n].trivial_error < 1e-6
    assert np.max(np.abs(direct)) < 1e-3
    assert not seen[2, 60].unreliable and np.max(np.abs(seen[2, 60].nontrivial)) < 1e-3
    assert not seen[3, 60].unreliable and seen[3, 60].spurious > 1e-5
    assert seen[3, 200].unreliable


def test_a_branch_does_not_start_where_its_multipliers_are_lost(tmp_path):
    mapping = {
        "model": "van_der_pol",
        "mesh": {"degree": 8, "intervals": 30},
        "steps": [
            {"name": "t", "simulate": {"t_end": 80}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "p",
                "delay": {"method": "chain", "order": 3, "n": 200},
                "orbit": {"from": "o", "stability": True},
            },
            {
                "name": "c",
                "delay": {"method": "chain", "order": 3, "n": 200},
                "continue": {"from": "p", "free": ["mu"], "range": {"mu": [0.5, 2]}, "stability": True},
            },
        ],
    }
    with pytest.raises(ConvergenceError, match="use more intervals"):
        run(mapping, tmp_path / "a.h5")
    step = read_results(tmp_path / "a.h5").step("p")
    assert step.points["stable"][0] == -1
    assert "WARNING" in describe_endings(step)[0]


def test_what_a_list_lacks_is_found_by_counting(monkeypatch):
    orbit = impact_oscillator()
    whole = find_multipliers(orbit)
    for kept in ([], [0], [1]):
        monkeypatch.setattr(module_of_multipliers, "find_candidates", lambda *_, kept=kept: whole.values[kept])
        found = find_multipliers(orbit)
        assert found.counted and found.values == pytest.approx(whole.values, abs=1e-12)


def test_a_line_of_which_no_multiplier_is_found_is_counted_all_the_same(monkeypatch):
    """Wright's orbit has its trivial multiplier, at least, outside the circle: an empty list is not confirmed."""
    orbit = settle_to_orbit("wright", delay={"method": "chain", "order": 2, "n": 8})
    assert find_multipliers(orbit).counted
    monkeypatch.setattr(module_of_candidates, "DENSE", 0)
    monkeypatch.setattr(module_of_candidates, "DENSE_LINES", 0)
    monkeypatch.setattr(module_of_multipliers, "find_candidates", lambda *_: np.zeros(0, dtype=complex))
    found = find_multipliers(orbit)
    assert not len(found.values) and not found.counted and not found.says_stability


def test_a_multiplier_of_a_line_that_is_not_corrected_is_missed_by_the_count(monkeypatch):
    """All eigenvalues of a small map are computed, but not all need be there after their correction."""
    orbit = settle_to_orbit("wright", delay={"method": "chain", "order": 2, "n": 8})
    whole = find_multipliers(orbit)
    first = max(whole.values.tolist(), key=abs)

    def lose(characteristic, value):
        return None if abs(value - first) < 1e-6 else refine(characteristic, value)

    monkeypatch.setattr(module_of_multipliers, "refine", lose)
    found = find_multipliers(orbit)
    assert len(found.values) < len(whole.values) and not found.counted


def test_what_no_count_confirms_says_nothing_of_stability(monkeypatch, tmp_path):
    monkeypatch.setattr(module_of_multipliers.Counter, "count_missing", lambda *_: None)
    monkeypatch.setattr(module_of_multipliers, "find_all_outside", lambda *_: None)
    monkeypatch.setattr(module_of_multipliers, "find_all_of_states", lambda *_: None)
    steps = [{"name": "t", "simulate": {"t_end": 120}}, {"name": "o", "orbit": {"from": "t", "stability": True}}]
    step = run({"model": "wall_oscillator", "steps": steps}, tmp_path / "a.h5").step("o")
    assert step.points["stable"][0] == -1 and step.points["n_unstable"][0] == -1
    assert "WARNING: the count of multipliers" in describe_endings(step)[0]
    assert "count of multipliers" in summarise_step(step)["termination"][0]


def test_residuals_stand_beside_the_multipliers(tmp_path):
    steps = [{"name": "t", "simulate": {"t_end": 120}}, {"name": "o", "orbit": {"from": "t", "stability": True}}]
    step = run({"model": "wall_oscillator", "steps": steps}, tmp_path / "a.h5").step("o")
    rows = make_table(step, "multipliers")
    assert len(rows) == 2 and all(0 <= row["residual"] < 1e-12 for row in rows)


@pytest.mark.parametrize("times", [1, 2, 3, 4])
def test_a_search_that_goes_astray_does_not_spoil_what_was_confirmed(monkeypatch, times):
    """Of four multipliers two are known; where the next is looked for nothing but the first is found, several times.

    What a count confirmed before is what remains.
    """
    characteristic = MapCharacteristic(np.diag([0.85, -0.37, 0.05, 0.02]))
    known = [refine(characteristic, value) for value in (0.851, -0.371)]
    monkeypatch.setattr(
        module_of_multipliers, "_find_missing", lambda counter, known, radius: np.full(times, 0.85, dtype=complex)
    )
    found, counted = module_of_multipliers.complete(characteristic, known, 12, deep=True)
    assert counted
    assert [m.value.real for m in found] == pytest.approx([0.85, -0.37], abs=1e-12)


def test_no_list_is_counted_twice_on_a_circle(monkeypatch):
    """Circles shrink step by step, and each new multiplier has all of them counted again: once."""
    characteristic = MapCharacteristic(np.diag([0.85, -0.37, 0.05, 0.02]))
    count, counted = module_of_multipliers._count, []

    def watched(counter, known, radius):
        counted.append((radius, *(m.value for m in known)))
        return count(counter, known, radius)

    monkeypatch.setattr(module_of_multipliers, "_count", watched)
    found, confirmed = module_of_multipliers.complete(characteristic, [], 12, deep=True)
    assert confirmed and len(found) == 4
    assert len(counted) == len(set(counted)) > 10


def test_what_was_asked_for_and_is_not_known_is_told(monkeypatch, tmp_path):
    """A branch none of whose orbits could be simulated in time, and none of whose multipliers a count confirms."""
    monkeypatch.setattr(module_of_multipliers.Counter, "count_missing", lambda *_: None)
    monkeypatch.setattr(module_of_multipliers, "find_all_outside", lambda *_: None)
    monkeypatch.setattr(module_of_multipliers, "find_all_of_states", lambda *_: None)
    monkeypatch.setattr(Examination, "simulate", lambda *_, **__: None)
    follow = {"from": "o", "free": ["omega"], "range": {"omega": [1.9, 2.1]}, "stability": True, "max_points": 3}
    steps = [{"name": "t", "simulate": {"t_end": 120}}, {"name": "o", "orbit": {"from": "t"}}]
    for given, unknown in (({}, True), ({"verify": False}, False)):
        branch = {"name": "b", "continue": {**follow, **given}}
        step = run({"model": "wall_oscillator", "steps": [*steps, branch]}, tmp_path / "a.h5").step("b")
        line, summary = describe_done(step), summarise_step(step)
        assert f"WARNING: at {len(step)} of the points the multipliers do not tell" in line
        assert summary["stability"]["unknown"] == len(step) and "do not tell" in summary["warning"]
        assert (f"WARNING: {len(step)} of its orbits could not be verified" in line) == unknown
        assert ("verified" in summary) == unknown
