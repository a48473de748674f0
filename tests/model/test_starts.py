"""A motion that starts beyond an event that ends its mode is warned of, and no other."""

import pytest

from pddecont.errors import RunError
from pddecont.model import parse_document
from pddecont.runfile import Overrides
from pddecont.steps import load_run_plan
from tests.cli.test_cli import call

MODEL = """name: m
states: [x, v]
parameters: {s: 0.3, tau: 1}
modes: {m: {x': v, v': -x}, n: {x': v, v': -2*x - x(t - tau)}}
events: {hit: x - s, out: v + 2}
resets: {b: {v: -v}}
segments:
  a: {mode: m, event: hit, direction: rising, reset: b, to: n}
  c: {mode: n, event: out, direction: falling, reset: b, to: m}
effects: {wall: {drop: [hit]}}
initial: {mode: m, x: 0, v: 0}
"""
RUN = "run:\n  steps:\n    - {name: t, simulate: {t_end: 9}}\n"
BEYOND = "the motion starts in mode '{}' with {}, beyond event '{}', which ends that mode where this is {} through zero"
AT_HIT = BEYOND.format("m", "-s + x = 0.1 > 0", "hit", "rising")
AT_OUT = BEYOND.format("n", "v + 2 = -1 < 0", "out", "falling")


def warned(*changes, **overrides):
    text = MODEL + RUN
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return [str(w) for w in load_run_plan(parse_document(text, "m.yaml"), Overrides(**overrides)).warnings]


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ("x: 0, v: 0}", "x: 0.4, v: 0}", f"m.yaml:14:17: {AT_HIT}"),
        ("mode: m, x: 0, v: 0}", "mode: n, v: -3}", f"m.yaml:14:17: {AT_OUT}"),
        ("t_end: 9", "t_end: 9, initial: {x: s + 0.1}", f"m.yaml:14:38: {AT_HIT}"),
        ("t_end: 9", "t_end: 9, initial: {mode: n, v: -3}", f"m.yaml:14:38: {AT_OUT}"),
        ("{name: t,", "{name: t, set: {s: -0.1},", f"m.yaml:14:33: {AT_HIT}"),
    ],
)
def test_a_start_beyond_the_event_is_warned_of(old, new, warning):
    found = warned((old, new))
    assert len(found) == 1
    assert found[0].startswith(warning)


@pytest.mark.parametrize(
    "changes",
    [
        [],
        [("x: 0, v: 0}", "x: 0.3, v: 0}")],
        [("mode: m, x: 0,", "mode: n, x: 0.4,")],
        [("x: 0, v: 0}", "x: 0.4, v: 0}"), ("rising", "any")],
        [("x: 0, v: 0}", "x: 0.4, v: 0}"), ("hit: x - s", "hit: sin(x) - s")],
        [("x: 0, v: 0}", "x: 0.4, v: 0}"), ("hit: x - s", "hit: x(t - tau) - s")],
        [
            ("x: 0, v: 0}", "x: 0.4, v: 0}"),
            ("hit: x - s", "hit: x - s*cos(2*pi*t)/4"),
            ("modes:", "forcing: {period: 1}\nmodes:"),
        ],
        [("x: 0, v: 0}", "x: 0.4, v: 0}"), ("t_end: 9", "t_end: 9, initial: {x: 0}")],
    ],
)
def test_other_starts_are_not(changes):
    assert warned(*changes) == []


def test_a_start_without_a_value_is_an_error_at_its_place():
    with pytest.raises(RunError, match=r"m\.yaml:14:27: the history at t = 0 is not a finite real number"):
        warned(("x: 0, v: 0}", "x: log(t), v: 0}"))


def test_an_event_that_is_left_out_is_not_missed():
    assert warned(("x: 0, v: 0}", "x: 0.4, v: 0}"), without=("wall",)) == []


@pytest.mark.parametrize(("x", "count"), [("0.4", 1), ("0", 0), ("log(t)", 0)])
def test_check_says_it_of_a_model_alone(tmp_path, monkeypatch, x, count):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.yaml").write_text(MODEL.replace("x: 0,", f"x: {x},"))
    code, out, err = call("check", "m.yaml")
    assert code == 0
    assert f"{count} warning(s)" in out
    assert err.startswith(f"m.yaml:11:1: {AT_HIT}" if count else "")
