"""Units: from the model to the monitors."""

from types import SimpleNamespace

import pytest

from pddecont.errors import ModelError
from pddecont.model import leave_out_effects
from pddecont.steps.execution.units import find_units
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
    assert leave_out_effects(model, ["feedback"]).units == model.units


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("units: {y: mm}", "m.yaml:4:9: 'y' is no state, parameter or definition"),
        ("units: {taw: s}", "did you mean 'tau'"),
        ("units: {x: 3}", "expected text, found a number"),
        ("units: [mm]", "expected a mapping, found a list"),
    ],
)
def test_wrong_units_are_told_at_their_place(line, message):
    with pytest.raises(ModelError, match=message):
        model_from("\n".join([*MODEL.splitlines()[:3], line, *MODEL.splitlines()[4:]]))


def test_monitors_have_the_units_of_what_they_measure():
    monitors = {
        "top": "max(x)",
        "low": " min( v ) ",
        "speed": "at(seg, v)",
        "contact": "time_in(m)",
        "T": "period",
        "force": "mean(u)",
        "ratio": "max(x)/min(x)",
        "square": "max(x**2)",
        "one": 1.0,
        "x": "time_in(m)",
    }
    model = model_from(MODEL)
    found = find_units(SimpleNamespace(model=model, shared={"monitors": monitors}))
    assert {name: found[name] for name in found if name not in model.units} == {
        "top": "mm",
        "low": "mm/s",
        "speed": "mm/s",
        "contact": "s",
        "T": "s",
        "force": "N",
    }
    assert found["x"] == "mm"  # the state keeps its own
