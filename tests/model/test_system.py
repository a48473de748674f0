"""Each kind of error in a model file, with its place and its words."""

import pytest

from pddecont.errors import ModelError, SignatureError
from pddecont.model import load_model, parse_document, parse_model
from pddecont.model.system import DelayedValue, check_signature
from tests.conftest import MODELS

GOOD = """\
name: m
states: [x, v]
parameters: {omega: 2, e: 1, tau: 0.5}
definitions: {force: sin(omega*t) - x(t - tau)}
forcing: {period: 2*pi/omega}
modes:
  free: {x': v, v': force}
  touch: {x': v, v': force - 10*(x - e)}
events:
  hit: x - e
resets:
  bounce: {v: -0.8*v}
segments:
  free: {mode: free, event: hit, direction: rising, reset: bounce, to: touch}
  touch: {mode: touch, event: hit, direction: falling, to: free}
effects:
  forcing: {set: {omega: 1}}
initial: {mode: free, x: 0.5*cos(t)}
"""


def found(text):
    with pytest.raises(ModelError) as info:
        parse_model(parse_document(text, "m.yaml", ModelError))
    return [(p.line, p.column, p.message) for p in info.value.problems]


def test_the_good_model():
    model, warnings = parse_model(parse_document(GOOD, "m.yaml"))
    assert warnings == []
    assert model.delayed == (DelayedValue(0, 0),)
    assert model.segments["touch"].reset == "identity"
    assert model.evaluate(model.resets["bounce"][1], {"v": 1.0}) == -0.8


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_shipped_models_are_free_of_warnings(path):
    assert load_model(str(path))[1] == []


@pytest.mark.parametrize(
    ("old", "new", "line", "column", "words"),
    [
        (
            "to: touch}",
            "to: contct}",
            14,
            72,
            "segment 'free' leads to mode 'contct', which is not defined (modes: free, touch)",
        ),
        ("to: touch}", "to: tuch}", 14, 72, "did you mean 'touch'?"),
        ("mode: free, event", "mode: fre, event", 14, 16, "runs in mode 'fre'"),
        ("event: hit, direction: r", "event: hitt, direction: r", 14, 29, "ends at event 'hitt'"),
        ("reset: bounce", "reset: bonce", 14, 60, "did you mean 'bounce'?"),
        ("  hit: x - e\n", "  hit: x - e\n  other: v\n", 11, 3, "event 'other' ends no segment"),
        ("{v: -0.8*v}", "{w: -0.8*v}", 12, 12, "sets 'w', which is not a state"),
        ("forcing: {period: 2*pi/omega}\n", "", 6, 3, "'t' appears in modes 'free' but the model has no 'forcing'"),
        ("x(t - tau)", "x(t + tau)", 4, 39, "the delay -tau is -0.5"),
        ("x(t - tau)", "x(t - abs(v))", 4, 43, "'abs' is not smooth, and a delay has to be"),
        ("v': force}\n  touch", "w': force}\n  touch", 7, 17, "'w'' is not the derivative of a state"),
        ("free: {x': v, v': force}", "free: {x': v}", 7, 3, "does not say what v' is"),
        ("free: {x': v, v'", "free: {x': v, v", 7, 17, "write v'"),
        ("rising", "up", 14, 45, "expected 'rising', 'falling' or 'any'"),
        ("effects:", "efects:", 16, 1, "unknown key 'efects'; did you mean 'effects'?"),
        ("direction: falling", "directoin: falling", 15, 36, "did you mean 'direction'?"),
        ("set: {omega: 1}", "set: {omga: 1}", 17, 19, "did you mean 'omega'?"),
        ("x: 0.5*cos(t)", "y: 0.5*cos(t)", 18, 23, "'y' is not a state"),
        ("{mode: free, x: 0", "{mode: fly, x: 0", 18, 17, "mode 'fly' is not defined"),
        ("[x, v]", "[x, sin]", 2, 13, "has a meaning of its own"),
        ("[x, v]", "[x, 2v]", 2, 13, "is not a name"),
        ("[x, v]", "[x, e]", 3, 24, "'e' stands already among the states"),
        ("omega: 2,", "omega: two,", 3, 21, "expected a number, found text"),
        ("name: m\n", "", 1, 1, "key 'name' is missing"),
        ("period: 2*pi/omega", "period: -omega", 5, 19, "the forcing period is -2"),
        ("sin(omega*t)", "sn(omega*t)", 4, 22, "unknown function 'sn'; did you mean 'sin'?"),
        ("force: sin", "force: force + sin", 4, 15, "defined by itself"),
        ("hit: x - e", "hit: {after: nothing, delay: 1}", 10, 16, "event 'nothing' is not defined"),
        ("hit: x - e", 'hit: __import__("os").getcwd()', 10, 8, "not allowed"),
    ],
)
def test_each_error_has_its_place_and_words(old, new, line, column, words):
    assert old in GOOD
    problems = found(GOOD.replace(old, new, 1))
    assert any(words in message for *_, message in problems), problems
    assert any((ln, co) == (line, column) and words in message for ln, co, message in problems), problems


def test_all_errors_are_reported_at_once():
    text = GOOD.replace("to: touch", "to: contct").replace("x - e\n", "x - ee\n").replace("{v: -0.8*v}", "{w: 1}")
    assert len(found(text)) == 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("tau: 0.5}", "tau: 0.5, spare: 1}", "parameter 'spare' is not used"),
        ("resets:\n", "resets:\n  spare: {v: 0}\n", "reset 'spare' is not used"),
        ("modes:\n", "modes:\n  spare: {x': v, v': 0}\n", "no segment leads to mode 'spare'"),
    ],
)
def test_warnings(old, new, words):
    warnings = parse_model(parse_document(GOOD.replace(old, new, 1), "m.yaml"))[1]
    assert len(warnings) == 1
    assert words in warnings[0].message


def test_a_signature_must_follow():
    model, _ = parse_model(parse_document(GOOD, "m.yaml"))
    check_signature(model, ["free", "touch", "free", "touch"])
    with pytest.raises(SignatureError, match="segment 'free' leads to mode 'touch', but 'free' runs in mode 'free'"):
        check_signature(model, ["free", "free"])
    with pytest.raises(SignatureError, match="did you mean 'touch'"):
        check_signature(model, ["tuch"])
