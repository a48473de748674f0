"""Branches that go on with another signature by themselves, or stop."""

from types import SimpleNamespace

import numpy as np
import pytest

from pddecont.bifurcation import SpecialPointKind, forget_kind, register_kind, signature_switching, switch_signature
from pddecont.bifurcation.extended_system import ExtendedEvaluation
from pddecont.continuation import BranchPoint, BranchState, End, Termination
from pddecont.tables import describe_endings, describe_reason
from tests.bifurcation.runs import CHAIN_COLLAPSE, CHAIN_GRAZING, signatures
from tests.problems import GRAZING_TAU
from tests.runs import labels, parameter, run

FREE_GRAZING_CHAIN = 0.175337013230  # closed form of the linear orbit, N = 15, M = 2, tau_d = 3.8


def test_from_impacts_to_none_without_user_action(fig4_7):
    step = fig4_7.step("c")
    assert labels(step) == ["GR1", "PD1", "VS1"]
    assert signatures(step) == ["NC C", "NC C NC C", "NC C", "(NC)"]
    assert describe_endings(step)[0] == (
        "up: reached the end of the range, K = 0.3; widen 'range' to go on, through the signatures [NC C], "
        "[NC C NC C], [NC C], [(NC)]"
    )
    assert np.all(step.points["admissible"] == 1)
    assert parameter(step, "K", "GR1") == pytest.approx(CHAIN_GRAZING, abs=1e-10)
    assert parameter(step, "K", "PD1") == pytest.approx(CHAIN_COLLAPSE, abs=1e-10)
    assert parameter(step, "K", "VS1") == pytest.approx(FREE_GRAZING_CHAIN, abs=1e-10)
    assert parameter(step, "K")[-1] == 0.3
    assert describe_reason(step.reason(step.row("VS1"))) == "C vanishes"


def test_stop_and_go_by_hand(fig4_7):
    stop, hand = fig4_7.step("stop"), fig4_7.step("by_hand")
    assert labels(stop) == ["GR1"]
    assert describe_endings(stop)[0].startswith(
        "up: stopped at a special point where the signature of the orbit changes (GR)"
    )
    assert signatures(hand)[0] == "NC C NC C"
    assert labels(hand) == ["PD1", "VS1"]
    assert parameter(hand, "K", "PD1") == pytest.approx(CHAIN_COLLAPSE, abs=1e-10)


def test_in_the_delay_through_both_grazings_to_the_free_orbit_and_back(tmp_path):
    text = {
        "model": "impact_oscillator",
        "mesh": {"degree": 9, "tol": 1e-10},
        "monitors": {"contact_time": "time_in(C)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "60*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {"from": "o", "free": ["tau_d"], "range": {"tau_d": [3, 6.5]}, "step": {"max": 0.05}},
            },
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["PD1", "GR1", "GR2", "PD2", "VS1", "GR3"]
    assert signatures(step) == ["NC C", "NC C NC C", "NC C", "NC C NC C", "NC C", "(NC)", "NC C"]
    assert [parameter(step, "tau_d", x) for x in ("GR1", "GR2")] == pytest.approx(
        [3.2164416411, 4.6951888028], abs=2e-9
    )
    assert [parameter(step, "tau_d", x) for x in ("VS1", "GR3")] == pytest.approx(GRAZING_TAU, abs=1e-9)
    assert np.all(step.points["admissible"] == 1)


def ended(kind, end, at="an orbit"):
    """Return how switching answers to a branch that ended at a point of a kind, and what it handed out."""
    last = SimpleNamespace(kind=kind, state=SimpleNamespace(point=SimpleNamespace(at=at)))
    handed = []
    return switch_signature(Termination(end), last, last.state, None, handed.append, 1), handed


@pytest.mark.parametrize("end", [e for e in End if e not in (End.SPECIAL, End.IMPOSSIBLE)])
def test_a_branch_that_ends_elsewhere_does_not_go_on(end):
    assert ended("GR", end) == (None, [])


@pytest.mark.parametrize("kind", ["LP", "BP", "TR", "", "unknown"])
def test_kinds_that_do_not_say_how_to_go_on_end_a_branch(kind):
    assert ended(kind, End.SPECIAL) == (None, [])


def test_a_curve_does_not_change_its_signature():
    at = ExtendedEvaluation(None, None)
    assert ended("GR", End.SPECIAL, at) == (None, [])


def test_a_kind_may_go_on_in_its_own_way(monkeypatch):
    """What it returns takes the place of the last ordinary point, at the arclength of the special one."""
    monkeypatch.setattr(signature_switching, "check_branch_joins", lambda point, orbit, settings: None)
    asked = []

    def go_on(last, before, settings):
        asked.append((last, before))
        return "beyond"

    register_kind(SpecialPointKind("XX", "a new one", go_on=go_on))
    try:
        at = SimpleNamespace(orbit=None)
        before = BranchState(SimpleNamespace(at=at), 1.0, 0.1, 7)
        last = BranchPoint(BranchState(SimpleNamespace(at=at), 1.5, 0.1, 7), "XX", 3)
        found = switch_signature(Termination(End.SPECIAL), last, before, None, None, 1)
    finally:
        forget_kind("XX")
    assert asked == [(last, before)]
    assert (found.point, found.arclength, found.step, found.n_points) == ("beyond", 1.5, 0.1, 7)
