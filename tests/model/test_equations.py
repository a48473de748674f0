"""What a file of equations may say, what it may not, and what leaving effects out leaves of it."""

import pytest

from pddecont.errors import ModelError, PddecontError
from pddecont.model import leave_out_effects, parse_document, parse_model
from tests.conftest import model_from
from tests.model.equations_models import STICK
from tests.runs import change, to_yaml

PLAIN = {
    "name": "m",
    "states": ["x"],
    "parameters": {"a": 1.0},
    "equations": {"x'": "-a*x - sign(x)"},
    "initial": {"x": 1},
}


def problems(model):
    """Return what is wrong with a model, as "line of its text: message"."""
    text = model if isinstance(model, str) else to_yaml(model)
    with pytest.raises(ModelError) as caught:
        model_from(text)
    lines = text.splitlines()
    return [(lines[p.line - 1].strip(), p.message) for p in caught.value.problems]


@pytest.mark.parametrize("key", ["modes", "events", "resets", "segments"])
def test_parts_of_models_by_hand_do_not_go_with_equations(key):
    body = {
        "modes": {"m": {"x'": 1}},
        "events": {"e": "x"},
        "resets": {"r": {"x": 0}},
        "segments": {"s": {"mode": "m", "event": "e", "direction": "any", "to": "m"}},
    }
    ((line, message),) = problems({**PLAIN, key: body[key]})
    assert (line, message.split(";")[0]) == (f"{key}:", f"'{key}' belongs to models written by hand")


@pytest.mark.parametrize("more", [{"switches": {"s": "x"}}, {"jumps": {"j": {"at": "x", "reset": {"x": 1}}}}])
def test_switches_and_jumps_go_with_equations(more):
    (key,) = more
    given = {"name": "m", "states": ["x"], "modes": {"m": {"x'": "-x"}}, **more}
    assert problems(given) == [(f"{key}:", f"'{key}' belongs to models that give 'equations'")]


def test_a_model_needs_one_of_both():
    ((_, message),) = problems({"name": "m", "states": ["x"]})
    assert message.startswith("a model needs 'equations' ({x': expression}) or 'modes'")


def test_nonsmooth_functions_do_not_go_with_modes():
    ((_, message),) = problems({"name": "m", "states": ["x"], "modes": {"m": {"x'": "-abs(x)"}}})
    assert "'abs' is not smooth: give the model as 'equations', where it is allowed" in message


@pytest.mark.parametrize(
    ("jump", "expected"),
    [
        ({"reset": {"x": 1}}, "a jump has one of 'at' (function), 'after' (event) and 'every' (time)"),
        ({"at": "x", "every": 1, "reset": {"x": 1}}, "a jump has one of 'at' (function), 'after' (event) and 'every'"),
        ({"after": "other", "reset": {"x": 1}}, "'after' and 'delay' belong together"),
        ({"at": "x", "delay": 1, "reset": {"x": 1}}, "'after' and 'delay' belong together"),
        ({"every": 1, "direction": "rising", "reset": {"x": 1}}, "'direction' belongs to 'at'"),
        ({"at": "x - 2"}, "key 'reset' is missing here"),
        ({"at": "x - 2", "reset": {}}, "at least 1"),
        ({"at": "x - 2", "reset": {"z": 1}}, "sets 'z', which is not a state"),
        ({"at": "x - 2", "reset": {"x": 1}, "in": {"slp": "+"}}, "'slp' is no switch; did you mean 'slip'?"),
        ({"at": "x - 2", "reset": {"x": 1}, "in": {"slip": "++"}}, "'+', '-' or '0'"),
        ({"after": "othr", "delay": 1, "reset": {"x": 1}}, "is no jump and no named switch; did you mean 'other'?"),
        ({"after": "jump", "delay": 1, "reset": {"x": 1}}, "jump 'jump' cannot come after itself"),
        ({"after": "other", "delay": -1, "reset": {"x": 1}}, "the delay of this jump is -1 at the given parameters"),
        ({"at": "y - 2", "reset": {"x": 1}}, "'y' is not defined"),
        pytest.param(*({"at": "x - 2", "reset": {"x": 1}, "when": "x"}, "this is no condition")),
        ({"at": "x - 2", "reset": {"x": 1}, "when": "a > 0"}, "the sign of a constant"),
    ],
)
def test_what_is_wrong_with_a_jump(jump, expected):
    other = {"at": "x - 3", "reset": {"x": 0}}
    found = problems({**PLAIN, "switches": {"slip": "x"}, "jumps": {"other": other, "jump": jump}})
    assert len(found) == 1
    assert expected in found[0][1]


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({"equations": {"z'": "-x"}}, "'z'' is not the derivative of a state"),
        ({"equations": {"x": "-x"}}, "'x' is not the derivative of a state; write x'"),
        ({"equations": {"x'": "-x - sing(x)"}}, "unknown function 'sing'; did you mean 'sin'?"),
        ({"equations": {"x'": "-x - sign(xx)"}}, "'xx' is not defined; did you mean 'x'?"),
        ({"equations": {"x'": "-x - square(t, 2)"}}, "'t' appears in equations 'x'' but the model has no 'forcing'"),
        ({"switches": {"a": "x"}}, "'a' stands for something else already; rename one"),
        ({"switches": {"s": "x", "r": "-2*x"}}, "this is the argument of switch 's' already"),
        ({"switches": {"s": "x", "r": "a"}}, "the sign of a constant"),
        ({"switches": {"s": "x"}, "jumps": {"s": {"at": "x", "reset": {"x": 1}}}}, "'s' is a switch already; rename"),
        ({"effects": {"e": {"drop": ["stp"]}}}, "jump 'stp' is not defined"),
        ({"initial": {"x": 1, "z": 2}}, "'z' is not a state"),
        ({"forcing": {"period": 2}, "equations": {"x'": "-x - mod(t, 3)"}}, "period"),
    ],
)
def test_what_is_wrong_elsewhere(more, expected):
    assert any(expected in message for _, message in problems({**PLAIN, **more}))


def test_a_switch_that_nothing_reads_is_warned_of():
    text = to_yaml({**PLAIN, "switches": {"slip": "x", "idle": "x - 5"}})
    model, warnings = parse_model(parse_document(text, "m.yaml"))
    assert [w.message for w in warnings] == ["no nonsmooth function reads the sign of switch 'idle'"]
    assert list(model.modes) == ["slip_below", "slip_above", "slip_on"]


FULL = {
    **STICK,
    "parameters": {**STICK["parameters"], "k": 3.0, "K": 0.2, "tau": 0.6},
    "switches": {"slip": "v", "wall": "x - 0.7"},
    "equations": {"x'": "v", "v'": "F*cos(om*t) - x - mu*sign(v) - k*max(x - 0.7, 0) + K*x(t - tau)"},
    "jumps": {
        "stop": {"at": "x - 1", "direction": "rising", "reset": {"v": "-v/2"}},
        "kick": {"after": "stop", "delay": 0.3, "reset": {"v": "v + 0.1"}},
        "late": {"after": "kick", "delay": 0.3, "reset": {"v": "v - 0.1"}},
    },
    "effects": {
        "friction": {"set": {"mu": 0}},
        "wall": {"set": {"k": 0}},
        "feedback": {"set": {"K": 0}},
        "impact": {"drop": ["stop"]},
        "kick": {"drop": ["kick"]},
    },
}


@pytest.mark.parametrize(
    ("effects", "without"),
    [
        (["friction"], "- mu*sign(v)"),
        (["wall"], "- k*max(x - 0.7, 0)"),
        (["feedback"], "+ K*x(t - tau)"),
        (["friction", "wall", "feedback"], ""),
    ],
)
def test_without_an_effect_modes_are_those_of_the_equations_without_its_terms(effects, without):
    law, names = FULL["equations"]["v'"], {"friction": "slip", "wall": "wall"}
    for term in [without] if without else ["- mu*sign(v)", "- k*max(x - 0.7, 0)", "+ K*x(t - tau)"]:
        law = law.replace(term, "")
    switches = {v: FULL["switches"][v] for k, v in names.items() if k not in effects}
    left = leave_out_effects(model_from(FULL), effects)
    expected = model_from({**change(FULL, "equations.v'", law), "switches": switches, "effects": {}})
    assert {k: [str(f) for f in body] for k, body in left.modes.items()} == {
        k: [str(f) for f in body] for k, body in expected.modes.items()
    }
    assert {k: (s.mode, s.event, s.to, str(s.guard)) for k, s in left.segments.items()} == {
        k: (s.mode, s.event, s.to, str(s.guard)) for k, s in expected.segments.items()
    }
    assert left.initial_mode == expected.initial_mode
    assert left.delays == expected.delays


def test_a_switch_that_is_left_out_is_listed_with_its_modes():
    left = leave_out_effects(model_from(FULL), ["friction"])
    assert [s.name for s in left.derived.equations.switches] == ["wall"]
    assert set(left.left_out.reasons["modes"]) == set(model_from(FULL).modes) - set(left.modes)
    assert set(left.modes) == {"wall_below", "wall_above"}


@pytest.mark.parametrize(
    ("effects", "jumps"),
    [(["impact"], set()), (["kick"], {"stop"}), ([], {"stop", "kick", "late"}), (["impact", "kick"], set())],
)
def test_jumps_go_and_take_those_along_that_come_after_them(effects, jumps):
    left = leave_out_effects(model_from(FULL), effects)
    assert {j.name for j in left.derived.equations.jumps} == jumps
    assert {e for e in left.events if e in FULL["jumps"]} == jumps
    assert set(left.modes) == set(model_from(FULL).modes)


def test_without_everything_the_model_is_smooth():
    left = leave_out_effects(model_from(FULL), ["friction", "wall", "impact", "feedback"])
    assert (list(left.modes), left.segments, left.delays) == (["smooth"], {}, ())


def test_an_effect_that_is_none():
    with pytest.raises(PddecontError, match="did you mean 'friction'"):
        leave_out_effects(model_from(FULL), ["frictio"])
