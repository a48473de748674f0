"""Segments that may lead to several modes: which there are, and what is wrong with their lists."""

import math

import pytest
import sympy

from pddecont.errors import ModelError, RunError
from pddecont.model import leave_out_effects, list_alternatives, parse_document, parse_model
from tests.guarded import RAMP, TOP
from tests.runs import change, monitor, plan, run, to_yaml


def parse(mapping):
    return parse_model(parse_document(to_yaml(mapping), "model.yaml"))[0]


def leading(to, **more):
    return change({**RAMP, **more}, "segments.tick.to", to)


def test_each_alternative_is_a_segment():
    model = parse(RAMP)
    assert list(model.segments) == ["tick>idle", "tick>feed", "tock>idle", "tock>feed"]
    v, ramp = model.state_symbols[0], model.parameter_symbols[0]
    guards = [model.segments[name].guard for name in ("tick>idle", "tick>feed")]
    assert guards == [v > ramp, v <= ramp]
    assert [s.name for s in list_alternatives(model, model.segments["tick>feed"])] == ["tick>idle", "tick>feed"]


def test_alternatives_that_lead_to_one_mode_are_one():
    to = [{"when": "v > 2", "mode": "feed"}, {"when": "v > 1", "mode": "idle"}, {"mode": "feed"}]
    model = parse(leading(to))
    v = model.state_symbols[0]
    assert [name for name in model.segments if name.startswith("tick")] == ["tick>feed", "tick>idle"]
    for value, feeds in ((0.5, True), (1.5, False), (2.5, True)):
        assert bool(model.segments["tick>feed"].guard.subs(v, value)) == feeds
        assert bool(model.segments["tick>idle"].guard.subs(v, value)) != feeds


def test_conditions_that_leave_nothing_over_need_no_last_one():
    to = [{"when": "v > ramp", "mode": "idle"}, {"when": "v <= ramp", "mode": "feed"}]
    assert len(parse(leading(to)).segments) == 4


@pytest.mark.parametrize(
    ("to", "message"),
    [
        ([{"when": "v > ramp", "mode": "idle"}], "leads nowhere where none of its conditions holds"),
        ([{"mode": "feed"}, {"when": "v > ramp", "mode": "idle"}], "never leads to mode 'idle' here"),
        ([{"when": "v > 1 and v <= 1", "mode": "idle"}, {"mode": "feed"}], "never leads to mode 'idle' here"),
        ([{"when": "v > ramp", "mode": "idel"}, {"mode": "feed"}], "'idel', which is not defined .*'idle'"),
        ([{"when": "v > rmp", "mode": "idle"}, {"mode": "feed"}], "'rmp' is not defined"),
        ([{"when": "v", "mode": "idle"}, {"mode": "feed"}], "this is no condition"),
        ([{"if": "v > ramp", "mode": "idle"}, {"mode": "feed"}], "unknown key 'if'"),
        ([{"when": "v > ramp"}, {"mode": "feed"}], "key 'mode' is missing here"),
        ([], "at least 1 item"),
    ],
)
def test_what_is_wrong_is_told(to, message):
    with pytest.raises(ModelError, match=message) as caught:
        parse(leading(to))
    assert len(caught.value.problems) == 1


def test_a_parameter_that_only_a_condition_reads_is_used():
    assert parse(RAMP).parameters["ramp"] == 0.6
    with pytest.raises(ModelError, match="'t' appears in segments 'tick'"):
        parse(leading([{"when": "v > t", "mode": "idle"}, {"mode": "feed"}]))


def test_without_an_effect_a_condition_may_hold_always_or_never():
    """Without the ramp all is idle after the first tick: 1 > 0."""
    when = {"when": "v > 0 and 1 > gate", "mode": "idle"}
    mapping = change(
        {**leading([when, {"mode": "feed"}]), "effects": {"gate": {"set": {"gate": 2}}}}, "parameters.gate", 0
    )
    model = leave_out_effects(parse(mapping), ["gate"])
    assert "tick>idle" not in model.segments
    assert model.segments["tick>feed"].guard == sympy.true
    assert "its condition never holds" in str(model.left_out.as_data())


def test_runs_name_segments_by_the_modes_they_lead_to(tmp_path):
    steps = [
        {"name": "t", "simulate": {"t_end": 30}},
        {"name": "o", "orbit": {"from": "t", "signature": ["tock>feed", "tick>idle", "tock>idle"]}},
    ]
    monitors = {"fed": "at(tick>idle, v)", "any": "at(tick, v)", "never": "at(tick>feed, v)"}
    step = run({**RAMP, "run": {"monitors": monitors, "steps": steps}}, tmp_path / "a.h5").step("o")
    assert [monitor(step, name)[0] for name in ("fed", "any")] == pytest.approx([TOP, TOP], abs=1e-12)
    assert math.isnan(monitor(step, "never")[0])
    with pytest.raises(RunError, match="'tick>idel' is not a segment"):
        plan({**RAMP, "run": {"steps": [steps[0], {"name": "o", "orbit": {"from": "t", "signature": ["tick>idel"]}}]}})
