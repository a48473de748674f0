"""Units: from the model to the axes."""

from types import SimpleNamespace

import pytest

from pddecont.errors import ModelError
from pddecont.model.effects import without
from pddecont.plot.units import axis_label, unit_of, written
from pddecont.results.reader import Step
from pddecont.steps.units import units_of
from tests.conftest import model_from

MODEL = """\
name: m
states: [x, v]
parameters: {K: 1, tau: 1}
units: {x: mm, v: mm/s, t: s, K: N s/m, u: N}
definitions: {u: K*x(t - tau)}
modes: {m: {x': v, v': u}}
effects: {feedback: {set: {K: 0}}}
"""


def test_units_are_kept_and_survive_effects():
    model = model_from(MODEL)
    assert model.units == {"x": "mm", "v": "mm/s", "t": "s", "K": "N s/m", "u": "N"}
    assert without(model, ["feedback"]).units == model.units


@pytest.mark.parametrize(("line", "message"), [
    ("units: {y: mm}", "m.yaml:4:9: 'y' is no state, parameter or definition"),
    ("units: {taw: s}", "did you mean 'tau'"),
    ("units: {x: 3}", "expected text, found a number"),
    ("units: [mm]", "expected a mapping, found a list"),
])  # fmt: skip
def test_wrong_units_are_told_at_their_place(line, message):
    with pytest.raises(ModelError, match=message):
        model_from("\n".join([*MODEL.splitlines()[:3], line, *MODEL.splitlines()[4:]]))


def test_monitors_have_the_units_of_what_they_measure():
    monitors = {"top": "max(x)", "low": " min( v ) ", "speed": "at(seg, v)", "contact": "time_in(m)", "T": "period", "force": "mean(u)",
                "ratio": "max(x)/min(x)", "square": "max(x**2)", "one": 1.0, "x": "time_in(m)"}  # fmt: skip
    plan = SimpleNamespace(model=model_from(MODEL), monitors=monitors)
    found = units_of(plan)
    assert {name: found[name] for name in found if name not in plan.model.units} == {
        "top": "mm", "low": "mm/s", "speed": "mm/s", "contact": "s", "T": "s", "force": "N"}  # fmt: skip
    assert found["x"] == "mm"  # the state keeps its own


def test_a_label_is_a_name_and_its_unit():
    step = Step("s", "orbit", {"units": {"tau_d": "s", "x": "m/s^2", "t": "s", "K": "N*s**-1"}}, {}, {}, (), True)
    assert axis_label(step, "tau_d") == r"$\tau_{d}$ (s)"
    assert axis_label([step], "x") == "$x$ (m/s$^{2}$)"
    assert axis_label(step, "K") == "$K$ (N*s$^{-1}$)"
    assert axis_label(step, "x(t - tau_d)") == "x(t - tau_d) (m/s$^{2}$)"
    assert axis_label(step, "period") == "period (s)"
    assert axis_label(step, "h_GR") == r"$h_{\mathrm{GR}}$"
    assert unit_of({}, "x") == ""
    assert written("$") == r"\$"
