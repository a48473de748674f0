"""Runs that once gave wrong numbers, lost something or were refused, as they stand in the files beside this one.

References: closed forms, calculations apart from the program, and what the same problem gives in other units.
``before`` is what the program said before it was mended, written down then.
"""

import math

import numpy as np
import pytest

from pddecont.errors import ModelError, PddecontError
from pddecont.model import parse_document, parse_model
from pddecont.tables import describe_endings
from tests.cases.pitchfork import find_pitchfork
from tests.cases.test_cases import HERE, follow, load, until
from tests.runs import change, labels, monitor, multipliers, parameter, run

# Outside walls reached after 2.535178: decay of perturbations, by own linearisation with saltation.
UNITS = [0.367602 + 0.790271j, -0.06485, 0.0321 + 0.0199j, -0.0157 + 0.0128j]


def said(name, tmp_path, step=None):
    """Return what a run that is refused says."""
    with pytest.raises(PddecontError) as caught:
        run(load(name) if step is None else until(load(name), step), tmp_path / "a.h5")
    return str(caught.value)


def test_multipliers_of_long_delays_are_those_of_none(tmp_path, mended):
    """Without feedback the delay changes nothing, however long it is and however many multipliers are wanted."""
    expected = 0.364364 + 0.086702j
    for n in (0.3, 5.3, 7.3):
        for wanted in (True, {"multipliers": 2}, {"multipliers": 20}):
            data = change(load("long_delay_multipliers"), "parameters.n", n)
            step = run(change(data, "run.steps.1.orbit.stability", wanted), tmp_path / "a.h5").step("o")
            assert step.points["n_unstable"][0] == 0
            leading = multipliers(step)
            assert leading[:2] == pytest.approx([expected, expected.conjugate()], abs=1e-6)
            assert np.all(np.abs(leading[2:]) < 1e-6)
    mended(
        "long_delay_multipliers",
        ".677 at n = 7.3, others with other numbers asked for",
        f"{leading[0]:.6f}",
        ".364364 + .086702i",
    )


def test_an_accuracy_is_met_by_the_recorded_estimate(tmp_path, mended):
    step = run(change(load("accuracy_not_kept"), "run.accuracy", 1e-6), tmp_path / "a.h5").step("o")
    estimate = step.points["error_estimate"][0]
    assert estimate <= 1e-6
    mended("accuracy_not_kept", "said 7.6e-7, was 1.1e-5", f"{estimate:.1e}", "1e-6 asked for")


@pytest.mark.parametrize("name", ["e33", "e34"])
def test_no_crossing_is_made_of_rounding(name, tmp_path, monkeypatch, mended):
    """Where the ramp turns the converter feeds just if the voltage is below the ramp, and it turns twice a period."""
    monkeypatch.chdir(HERE)
    step = follow("buck_lost_event", tmp_path, name)
    p = dict(zip(step.meta["parameters"], step.points["parameters"][0], strict=True))
    names = np.array([step.meta["segments"][k] for k in step.orbits["event_segment"]])
    turns = 0
    for side, level in (("top", p["gamma"] + p["rise"]), ("low", p["gamma"])):
        here = np.char.startswith(names, side)
        feeds, voltage = np.char.endswith(names[here], "feed"), step.orbits["before"][here, 0]
        assert (feeds == (voltage < level)).all()
        turns += len(feeds)
    # The last one is due as the simulation ends.
    assert turns == 2 * 1500 - 1
    mended(
        f"buck_lost_event, {name}",
        "an edge made of rounding: feeds above the ramp for good",
        "none",
        "u at 2,999 turns",
    )


@pytest.mark.parametrize("name", ["units_si", "units_micro"])
def test_units_change_no_multiplier(name, tmp_path, mended):
    data = load(name)
    step = run(change(until(data, "o"), "run.steps.1.orbit.stability", {"multipliers": 8}), tmp_path / "a.h5").step("o")
    found = multipliers(step)
    for value in UNITS:
        assert np.min(np.abs(found - value)) < 1e-4
    shown = ", ".join(f"{m:.4f}" for m in found[2:5])
    mended(name, "-.0619, -.0584 after the leading pair", shown, "-.0649, .0321 + .0199i, ..")


def test_where_multiples_of_a_delay_meet_whole_periods_the_branch_goes_on(tmp_path, mended):
    branch = follow("branch_dies", tmp_path)
    tau = parameter(branch, "tau")
    assert [min(tau), max(tau)] == [0.1, 1.4] and not labels(branch)
    assert branch.points["period"] == pytest.approx(math.log(2.0), abs=1e-9)
    mended("branch_dies", "turns too sharply at tau = .4 T", "tau from 0.1 to 1.4", "T = ln 2")


def test_a_pitchfork_just_after_a_pair_has_met_is_found(tmp_path, mended):
    branch = follow("pitchfork_lost", tmp_path)
    place = parameter(branch, "k", "BP1")
    assert place == pytest.approx(0.481996, abs=1e-6)
    assert not any("not located" in text for text in describe_endings(branch))
    mended("pitchfork_lost", "1 change of stability not located", f"BP at {place:.7g}", ".481996")


def test_the_same_pitchfork_of_the_neutral_equation_itself(tmp_path, mended):
    """With the delayed acceleration in place of a difference quotient over .001, which moves the point by 2.4e-7."""
    branch = follow("pitchfork_neutral", tmp_path)
    place = parameter(branch, "k", "BP1")
    # The default mesh tolerance; the program is 1.2e-8 off.
    assert place == pytest.approx(find_pitchfork(), abs=1e-7)
    assert [label for label in labels(branch) if label[:2] in ("BP", "LP")] == ["BP1", "LP1"]
    assert not any("not located" in text for text in describe_endings(branch))
    mended("pitchfork_neutral", "a difference quotient", f"BP at {place:.9g}", "the neutral equation itself")


def test_contacts_that_a_symmetric_orbit_loses_at_once_are_removed_together(tmp_path, mended):
    branch = follow("symmetric_impacts", tmp_path, "b1")
    om = parameter(branch, "om")
    assert max(om) == 3.3
    signatures = {branch.orbit(i)["signature"].tobytes().decode() for i in range(len(branch))}
    assert "(free)" in signatures
    mended("symmetric_impacts", "take smaller steps", "to om = 3.3 through [(free)]", "orbit without impacts")


def test_a_closed_branch_is_followed_once(tmp_path, monkeypatch, mended):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bang_bang.yaml").write_text((HERE / "bang_bang.yaml").read_text())
    run(until(load("bang_bang"), "b"), tmp_path / "bang_bang.h5")
    branch = run(load("bang_bang_loop"), tmp_path / "a.h5").step("sec")
    assert branch.endings[0].code == "closed"
    found = labels(branch)
    mended("bang_bang_loop", "LP1 to LP21, PD1 to PD16 until max_points", f"closed, {len(found)} points", "one loop")


def test_an_orbit_that_sticks_is_one(tmp_path, mended):
    """The block goes to x = 1.28 and sticks there: independent simulation."""
    step = follow("friction_stick", tmp_path, "orbit")
    top = monitor(step, "x_max")[0]
    assert top == pytest.approx(1.28, abs=1e-6)
    assert step.points["verified"][0] == 1
    mended("friction_stick", "no signature lists the events", f"largest x {top:.7g}", "1.280000")


def test_a_constant_state_does_not_keep_a_motion_from_having_settled(tmp_path, mended):
    step = follow("hold_false_not_settled", tmp_path, "orbit")
    assert step.points["stable"][0] == 1
    mended("hold_false_not_settled", "has not settled", f"period {step.points['period'][0]:.4g}", "settled to 1e-12")


def test_an_orbit_whose_event_a_jump_makes_is_found(tmp_path, mended):
    step = follow("buck_jump_event_orbit", tmp_path, "orbit")
    assert step.points["verified"][0] == 1
    signature = step.orbit(0)["signature"].tobytes().decode()
    mended(
        "buck_jump_event_orbit", "read far outside its mesh interval", f"[{signature}]", "the simulation's signature"
    )


@pytest.mark.parametrize(
    ("name", "step", "before", "message"),
    [
        ("trigger_family", "orbit", "cannot lower the residual", "can be singled out"),
        ("clock_still_grows", "orbit", "settles to an equilibrium", "in one direction up to the end"),
        ("decays_to_rest", "o", "quasi-periodic or chaotic", "its swings shrink"),
    ],
)
def test_what_a_motion_does_that_is_no_orbit_is_said(name, step, before, message, tmp_path, monkeypatch, mended):
    monkeypatch.chdir(HERE)
    text = said(name, tmp_path, step)
    assert message in text
    mended(name, before, f"says: {message}", "the simulation")


def test_of_two_segments_alike_the_second_is_told(mended):
    text = (HERE / "two_segments_alike.yaml").read_text()
    with pytest.raises(ModelError, match="'PS' can never happen") as caught:
        parse_model(parse_document(text, "two_segments_alike.yaml"))
    assert len(caught.value.problems) == 2
    mended("two_segments_alike", "no error", "'PS' and 'MS' can never happen", "the first is taken")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["capsule", "drill_run"])
def test_where_two_events_meet_and_nothing_joins_the_branch_ends_and_says_so(name, tmp_path, monkeypatch, mended):
    """A halt meets a release: beyond, the motion as it is written leaves for an orbit elsewhere."""
    monkeypatch.chdir(HERE)
    branch = follow(name, tmp_path, "branch")
    assert all("beyond, as the motion goes on" in text for text in describe_endings(branch))
    assert np.all(branch.points["verified"] == 1)
    n = len({branch.orbit(i)["signature"].tobytes() for i in range(len(branch))})
    mended(name, "ends where two events meet", f"{n} signatures, and says what is beyond", "simulation beyond")


@pytest.mark.slow
def test_a_torus_curve_ends_at_its_hopf_hopf_point(tmp_path, monkeypatch, mended):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "duff.yaml").write_text((HERE / "duff.yaml").read_text())
    run(load("duff2"), tmp_path / "duff2.h5")
    curve = follow("duffing_torus_curve", tmp_path, "trc")
    assert curve.endings[-1].code == "shrinks"
    tau, b = (parameter(curve, name, "HH1") for name in ("tau", "b"))
    # Roots i w of w^2 = a + b + i d w - b exp(-i w tau): the modulus gives both w, and both fit the delay.
    a, d = 0.5, 0.05
    for square in np.roots([1.0, d**2 - 2 * (a + b), (a + b) ** 2 - b**2]):
        w = math.sqrt(square)
        assert abs(a + b - square + 1j * d * w - b * np.exp(-1j * w * tau)) < 1e-8
    mended("duffing_torus_curve", "runs on along x = 0", f"HH at tau = {tau:.8g}, b = {b:.8g}", "HH point")
