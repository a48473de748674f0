"""Runs without effects: what an effect sets cannot be given, what it took along is named with the reason, what a run
names stays.
"""

import json

import numpy as np
import pytest

from pddecont.errors import RunError
from pddecont.model import parse_document
from pddecont.runfile import Overrides, write_run
from pddecont.steps import load_run_plan
from tests.cli.test_cli import call
from tests.runs import change, to_yaml

SET = r"'K' is set to 0 by leaving out effect 'feedback'; keep the effect, or leave 'K' as it is"
TRANSIENT = {"name": "t", "simulate": {"t_end": 10}}
ORBIT = {"name": "o", "orbit": {"from": "t"}}
ALONG = {
    "name": "b",
    "continue": {"from": "o", "free": ["a"], "range": {"a": [0, 1]}, "events_along": {"u": "mean(w)"}},
}


def sweep(**keys):
    return {"name": "s", "sweep": {"over": {"beta": [20, 30, 2]}, "transient": 100, **keys}}


def record(signal):
    return {"name": "t", "simulate": {"t_end": 10, "record": {"signals": {"s": signal}}}}


def plan(*steps, off=("feedback",), overrides=None, **more):
    made = {"model": "full_oscillator", "effects": {"off": list(off)}, **more, "steps": list(steps)}
    return load_run_plan(write_run(made, None, {}), overrides)


@pytest.mark.parametrize(
    ("more", "steps"),
    [
        ({"set": {"K": 0.2}}, [TRANSIENT]),
        ({}, [{"name": "t", "set": {"K": 0.2}, "simulate": {"t_end": 10}}]),
        ({}, [{"name": "t", "simulate": {"t_end": 10, "at": {5: {"K": 0.2}}}}]),
        ({}, [TRANSIENT, ORBIT, {"name": "b", "continue": {"from": "o", "free": ["K"], "range": {"K": [0, 1]}}}]),
        ({}, [sweep(over={"K": [0, 1, 3]})]),
    ],
)
def test_a_parameter_that_an_effect_set_cannot_be_given(more, steps):
    with pytest.raises(RunError, match=SET):
        plan(*steps, **more)


def test_nor_on_the_command_line():
    with pytest.raises(RunError, match=f"--set K=0.2: {SET}"):
        plan(TRANSIENT, overrides=Overrides((("K", "0.2"),)))
    made = plan(TRANSIENT, off=(), overrides=Overrides((("K", "0.2"),)))
    assert made.name_values(made.parameters)["K"] == 0.2


@pytest.mark.parametrize(
    ("off", "more", "steps", "message"),
    [
        (
            ["impact", "friction"],
            {"monitors": {"c": "time_in(hit_up)"}},
            [TRANSIENT],
            "'hit_up' is not a mode; it is left out: no segment left leads to it without effect 'impact'",
        ),
        (
            ["impact"],
            {"monitors": {"c": "at(meet, v)"}},
            [TRANSIENT],
            "'meet' is not a segment; it is left out: its event 'impact' never happens without effect 'impact'",
        ),
        (
            ["impact"],
            {"monitors": {"c": "extremum(impact)"}},
            [TRANSIENT],
            "'impact' is not an event; it is left out: it never happens without effect",
        ),
        (
            ["impact"],
            {},
            [sweep(section={"event": "impact"})],
            "'impact' is not an event; it is left out: it never happens",
        ),
        (
            ["impact"],
            {},
            [{"name": "t", "simulate": {"t_end": 9, "stick": {"impact": "free_up"}}}],
            "'impact' is not an event; it is left out",
        ),
        (
            ["impact"],
            {},
            [TRANSIENT, {"name": "o", "orbit": {"from": "t", "signature": ["meet", "slip"]}}],
            "'meet' is not a segment of this model; it",
        ),
        (["cutting"], {}, [record("x(t - tau_c)")], r"it is left out: nothing left reads it without effect 'cutting'"),
        (
            ["forcing"],
            {},
            [sweep()],
            "the model has no forcing .*; it is left out: 't' appears nowhere any more without effect 'forcing'",
        ),
    ],
)
def test_what_an_effect_took_along_is_named_with_the_reason(off, more, steps, message):
    with pytest.raises(RunError, match=message):
        plan(*steps, off=off, **more)


@pytest.mark.parametrize(
    ("more", "steps"),
    [
        ({"monitors": {"m": "max(w)"}}, [TRANSIENT]),
        ({"monitors": {"m": "max(filter)"}}, [TRANSIENT]),
        ({}, [record("w + x")]),
        ({}, [sweep(section={"zero": "w"})]),
        ({}, [TRANSIENT, {"name": "c", "precision": {"from": "t", "quantities": {"q": "w"}}}]),
        ({}, [sweep(random={"number": 2, "box": {"w": [0, 1]}})]),
        ({}, [{"name": "s", "basin": {"over": {"x": [0, 1, 2], "w": [0, 1, 2]}, "transient": 100}}]),
        ({}, [TRANSIENT, ORBIT, ALONG]),
    ],
)
def test_a_state_that_the_run_names_stays(more, steps):
    assert plan(*steps, **more).model.states == ("x", "v", "w")


def test_initial_values_of_what_is_left_out_mean_nothing():
    initial = {"w": 1, "x": 2, "history": {"w": "cos(t)"}}
    assert plan({"name": "t", "simulate": {"t_end": 10, "initial": initial}}).model.states == ("x", "v")
    with pytest.raises(RunError, match="'q' is not a state"):
        plan({"name": "t", "simulate": {"t_end": 10, "initial": {"q": 1}}})


def test_two_effects_that_set_one_parameter_differently_are_an_error_of_the_file():
    model = (
        "name: m\nstates: [x]\nparameters: {k: 1}\nmodes: {m: {x': -k*x}}\n"
        "effects: {a: {set: {k: 0}}, b: {set: {k: 2}}}\n"
        "run: {effects: {off: [a, b]}, steps: [{name: t, simulate: {t_end: 1}}]}\n"
    )
    with pytest.raises(RunError, match=r"m\.yaml:6:.*effects 'a' and 'b' cannot both be left out"):
        load_run_plan(parse_document(model, "m.yaml"))


FOLLOWING = {
    "name": "m",
    "states": ["x", "v"],
    "parameters": {"k": 4, "c": 1, "F": 1},
    "forcing": {"period": "2*pi"},
    "modes": {"m": {"x'": "v", "v'": "F*cos(t) - k*x - c*v"}},
    "effects": {"own": {"set": {"c": "k/4"}}},
    "run": {
        "effects": {"off": ["own"]},
        "monitors": {"size": "amplitude(x)", "damping": "c + 0*period"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "60*pi"}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "b", "continue": {"from": "o", "free": ["k"], "range": {"k": [3, 5]}}},
            {"name": "s", "sweep": {"over": {"k": [3, 5, 2]}, "transient": "80*pi"}},
        ],
    },
}


def test_a_value_in_terms_of_another_parameter_follows_it_in_results_and_tables(in_folder):
    (in_folder / "m.yaml").write_text(to_yaml(FOLLOWING))
    assert call("run", "m.yaml", "-q")[0] == 0
    rows = json.loads(call("export", "m.h5", "--step", "b", "--table", "points", "--format", "json")[1])
    k, c, size, damping = (np.array([row[name] for row in rows]) for name in ("k", "c", "size", "damping"))
    assert c == pytest.approx(k / 4, rel=1e-14)
    assert damping == pytest.approx(k / 4, rel=1e-14)
    assert size == pytest.approx(1 / np.hypot(k - 1, k / 4), rel=1e-8)
    rows = json.loads(call("export", "m.h5", "--step", "s", "--table", "points", "--format", "json")[1])
    assert [(row["k"], row["c"]) for row in rows] == [(3.0, 0.75), (5.0, 1.25)]


def test_info_of_a_run_file_says_what_its_model_is_without(in_folder):
    made = {"model": "full_oscillator", "effects": {"off": ["feedback"]}, "steps": [TRANSIENT]}
    (in_folder / "r.yaml").write_text(to_yaml(made))
    data = json.loads(call("info", "r.yaml", "--without", "cutting", "--json")[1])
    assert data["states"] == ["x", "v"]
    assert data["parameters"]["K"] == 0.0
    assert data["effects"] == ["forcing", "damping", "friction", "impact"]
    assert data["left out"]["effects"] == ["feedback", "cutting"]
    assert data["left out"]["states"] == {"w": "nothing left reads it without effect 'feedback'"}


def test_info_of_a_model_heeds_its_own_run_block(in_folder):
    (in_folder / "m.yaml").write_text(to_yaml(FOLLOWING))
    data = json.loads(call("info", "m.yaml", "--json")[1])
    assert data["left out"] == {"effects": ["own"], "parameters": {"c": "set to k/4 by leaving out effect 'own'"}}


def test_a_file_gone_on_with_without_other_effects_says_so_at_each_step(in_folder):
    steps = [{"name": name, "simulate": {"t_end": 5}} for name in ("t", "u")]
    (in_folder / "r.yaml").write_text(to_yaml({"model": "full_oscillator", "steps": steps}))
    assert call("run", "r.yaml", "-q", "--until", "t")[0] == 0
    assert json.loads(call("info", "r.h5", "--json")[1])["left out"] == {}
    assert call("run", "r.yaml", "-q", "--resume", "--only", "u", "--without", "feedback")[0] == 0
    data = json.loads(call("info", "r.h5", "--json")[1])
    assert data["left out"] == {}
    assert [step["left out"].get("effects") for step in data["steps"]] == [None, ["feedback"]]
    assert data["steps"][1]["left out"]["states"] == {"w": "nothing left reads it without effect 'feedback'"}
    # What was computed with all effects is not taken for what would be without.
    code, _, err = call("run", "r.yaml", "-q", "--resume", "--without", "feedback")
    assert code == 1
    assert "step 't' of r.h5 was computed with other settings" in err


DRIVEN = {
    "name": "m",
    "states": ["x", "v"],
    "parameters": {"mu": 1, "F": 1, "n": 1, "k": 0},
    "forcing": {"period": "2*pi"},
    "modes": {"m": {"x'": "v", "v'": "n*mu*(1 - x**2)*v - (1 - n)*v - x + F*cos(t)"}},
    "effects": {"drive": {"set": {"F": 0}}, "pump": {"set": {"n": 0}}},
    "initial": {"x": 2, "v": 0},
    "run": {
        "effects": {"off": ["drive"]},
        "monitors": {"top": "max(x)"},
        "steps": [{"name": "t", "simulate": {"t_end": 200}}, {"name": "o", "orbit": {"from": "t", "stability": True}}],
    },
}


def test_without_its_forcing_a_self_sustained_motion_has_its_own_period(in_folder):
    (in_folder / "m.yaml").write_text(to_yaml(DRIVEN))
    assert call("run", "m.yaml", "-q")[0] == 0
    # Van der Pol's oscillator at mu = 1.
    [row] = json.loads(call("export", "m.h5", "--step", "o", "--table", "points", "--format", "json")[1])
    assert row["period"] == pytest.approx(6.6632868593231, rel=1e-8)
    assert row["F"] == 0.0
    (in_folder / "d.yaml").write_text(to_yaml(change(DRIVEN, "run.effects.off", ["drive", "pump"])))
    code, _, err = call("run", "d.yaml", "-q")
    assert code == 3
    assert "the motion comes to rest" in err
