"""What depends on t repeats after the forcing period, or the model is refused."""

import pytest

from pddecont.errors import ModelError
from pddecont.model import parse_document, parse_model
from pddecont.model.expression import TIME
from pddecont.model.periodicity import explain_non_periodic
from pddecont.model.system import make_symbol

TEXT = """name: m
states: [x, v]
parameters: {omega: 0.8, a: 0.9, k: 1e9}
forcing: {period: 2*pi/omega}
definitions: {push: a*cos(omega*t)}
modes: {free: {x': v, v': push - k*x - x(t - a)}}
events: {hit: x - 2 + sin(omega*t)**2}
resets: {back: {v: -0.5*v + cos(omega*t)}}
segments: {free: {mode: free, event: hit, direction: rising, reset: back, to: free}}
"""
LATER = "does not repeat after the forcing period"


def model(*changes):
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return parse_model(parse_document(text, "m.yaml"))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ([("2*pi/omega", "pi/omega")], f"cos(omega*t) in v' of mode 'free' {LATER} 3.9269908: it is "),
        (
            [("push - k", "push + sin(3*omega*t/2)*x - k")],
            f"sin(3*omega*t/2) in v' of mode 'free' {LATER} 7.8539816: it is ",
        ),
        ([("+ sin(omega*t)**2", "+ sin(omega*t/3)**2")], f"sin(omega*t/3)**2 in event 'hit' {LATER}"),
        ([("+ cos(omega*t)", "+ 1e-3*t")], f"t in v of reset 'back' {LATER}"),
        ([("+ sin(omega*t)**2", "+ log(x)*sqrt(v)*cos(t)")], f"cos(t) in event 'hit' {LATER}"),
        ([("push - k", "log(t)*(2 + push) - k")], f"log(t) in v' of mode 'free' {LATER}"),
    ],
)
def test_a_wrong_period_is_refused_at_its_place(changes, message):
    with pytest.raises(ModelError) as caught:
        model(*changes)
    text = str(caught.value)
    assert text.startswith(f"m.yaml:4:19: {message}")
    assert text.endswith("; give the period of all that depends on t")


def test_the_values_a_period_apart_are_told():
    t = TIME
    found = explain_non_periodic([("y", t**2)], 2.0, {})
    values = dict(part.split(" at t = ")[::-1] for part in found.split("it is ")[1].split(" and "))
    (t0, a), (t1, b) = ((float(k), float(v)) for k, v in values.items())
    assert (t1 - t0, a, b) == pytest.approx((2.0, t0**2, t1**2), abs=1e-4)


@pytest.mark.parametrize(
    "changes",
    [
        [],
        [("2*pi/omega", "4*pi/omega")],
        [("push - k", "sin(omega*t/2)*cos(omega*t/2) + sin(omega*t/2)**2 - k")],
        [("push - k", "1e5*(1 - tanh(40*(2 + push))) - k")],
        [("push - k", "tanh(1e4*push) - k")],
        [("push - k", "sqrt(push - 20)*log(x - 9) - k")],
        [("push - k", "1e6*(x + push)*(1e6 + push) - k")],
    ],
)
def test_what_repeats_is_accepted(changes):
    assert model(*changes)[0].forced


def test_a_difference_at_one_point_is_no_proof():
    x = make_symbol("x")
    assert explain_non_periodic([("y", x + TIME)], 1.0, {})
    assert explain_non_periodic([("y", x)], 1.0, {}) == ""
