"""Where branches start, and from what they do not."""

import math

import numpy as np
import pytest

from pddecont.bifurcation import (
    BranchSettings,
    ExtendedEvaluation,
    SpecialPointKind,
    StartError,
    define_special_point,
    forget_kind,
    register_kind,
    start_after_grazing,
    start_curve,
    start_on_orbit,
    start_other_branch,
)
from pddecont.bifurcation.starting_point import name_point
from pddecont.bifurcation.user_function import UserFunction
from pddecont.collocation import MeshRule
from pddecont.errors import SignatureError
from pddecont.orbit import Orbit, parse_monitor
from pddecont.reasons import NO_REASON, make_reason
from tests.bifurcation import runs
from tests.bifurcation.runs import chain, free_amplitude
from tests.runs import parameter, run


def test_another_signature_than_the_grazings_is_refused(tmp_path, fig4_7):
    start = {"file": str(fig4_7.path), "step": "stop", "point": "GR1"}
    keys = {"from": start, "free": ["K"], "range": {"K": [0.1, 0.3]}, "signature": ["NC", "C", "NC", "C", "NC", "C"]}
    with pytest.raises(SignatureError, match=r"the grazing leads to \[NC, C, NC, C\]"):
        run(chain(0.12, [{"name": "c", "continue": keys}]), tmp_path / "a.h5")


def test_a_curve_may_start_at_the_edge_of_its_range(ball, tmp_path):
    start, limits = {"file": str(ball.path), "step": "c", "point": "PD1"}, {"r": [0.5, 0.8], "G": [0.3, 3]}
    keys = {"from": start, "free": ["r", "G"], "range": limits, "direction": "down"}
    step = run(runs.ball([{"name": "pd", "continue": keys}]), tmp_path / "a.h5").step("pd")
    assert parameter(step, "r")[-1] == pytest.approx(0.8, abs=1e-12)
    assert len(step) > 5


RULE = MeshRule(8, tol=1e-9)


def in_parameters(*free, **more):
    return BranchSettings(free, ((0.0, 3.0),) * len(free), RULE, **more)


def test_points_are_called_by_their_labels():
    assert name_point("GR") == "a GR point" and name_point("") == "an ordinary point"


@pytest.mark.parametrize(("kind", "name"), [("GR", "a GR point"), ("", "an ordinary point"), ("??", "a ?? point")])
def test_only_some_points_have_another_branch(free_orbit, kind, name):
    with pytest.raises(StartError) as caught:
        start_other_branch(free_orbit, kind, np.zeros(3), in_parameters("c"))
    assert str(caught.value) == f"'branch: switch' starts from a BP or PD point, not from {name}"


def test_only_some_points_are_followed_in_two_parameters(free_orbit):
    settings = in_parameters("omega", "c")
    system, orbit = settings.make_system(free_orbit)
    for start in (
        lambda: start_curve(free_orbit, "BP", NO_REASON, settings),
        lambda: define_special_point(system.at(orbit.x), "BP", NO_REASON, settings),
    ):
        with pytest.raises(StartError) as caught:
            start()
        assert str(caught.value) == (
            "it has two free parameters: it follows a special point (LP, PD, TR, GR, VS, GD, CS, GS, SS, AS or UF) "
            "and cannot start from a BP point"
        )


def test_kinds_that_are_made_known_are_among_those_that_can_be_started_from(free_orbit):
    register_kind(SpecialPointKind("XX", "a new one", define=lambda *_: None, switch=lambda *_: "switched"))
    try:
        assert start_other_branch(free_orbit, "XX", np.zeros(3), in_parameters("c")) == "switched"
        with pytest.raises(StartError, match=r"\(LP, PD, TR, GR, VS, GD, CS, GS, SS, AS, UF or XX\)"):
            start_curve(free_orbit, "", NO_REASON, in_parameters("omega", "c"))
    finally:
        forget_kind("XX")


def test_another_signature_begins_at_a_grazing_alone(hop_orbit):
    with pytest.raises(SignatureError) as caught:
        start_after_grazing(hop_orbit, "PD", ["flight", "flight"], in_parameters("wall"))
    assert str(caught.value) == (
        "asks for the signature [flight, flight], but its start runs through [flight]; another signature begins at a "
        "GR point"
    )


def test_a_start_on_an_orbit_corrects_its_guess(free_orbit):
    rng = np.random.default_rng(0)
    guess = Orbit(free_orbit.problem, free_orbit.x + 1e-3 * rng.standard_normal(len(free_orbit.x)))
    start = start_on_orbit(guess, in_parameters("c"))
    assert np.max(np.abs(start.point.at.residual)) < 1e-9
    assert start.point.at.orbit.period == pytest.approx(math.pi, abs=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("free", [("omega", "c"), ("c", "omega")])
def test_a_curve_starts_towards_larger_values_of_its_first_parameter(free_orbit, monkeypatch, free, sign):
    """The amplitude is kept: dw / dc = -c w^2 / (c^2 w - 2 w (1 - w^2)) along the curve."""
    level = parse_monitor(free_orbit.numeric, "level", f"max(x) - {free_amplitude(2.0)}")
    settings = in_parameters(*free, user_functions=(level,))
    whole = ExtendedEvaluation.direction_along
    monkeypatch.setattr(ExtendedEvaluation, "direction_along", lambda at: sign * whole(at))
    start = start_curve(free_orbit, "UF", make_reason("user_function", name="level"), settings)
    point = start.point
    assert (start.kind, start.one_way) == ("UF", False)
    assert isinstance(point.at.system.defining, UserFunction)
    moves = dict(zip(free, point.tangent[point.at.orbit.problem.unknowns.free], strict=True))
    assert moves[free[0]] > 0.0
    w, c = (dict(zip(free, point.at.orbit.free, strict=True))[name] for name in ("omega", "c"))
    assert free_amplitude(w, c) == pytest.approx(free_amplitude(2.0), abs=1e-9)
    assert moves["omega"] / moves["c"] == pytest.approx(c * w**2 / (2 * w * (1 - w**2) - c**2 * w), rel=1e-4)
