"""Cycles in tables: segments cut at events or by a column, wherever the rows begin."""

import math

import numpy as np
import pytest

from pddecont.codegen import NumericModel
from pddecont.errors import SignatureError
from pddecont.model import parse_document, parse_model
from pddecont.orbit import find_cycle, read_motion_table
from tests.conftest import shipped
from tests.runs import to_yaml

# x' = 1 up to 1, then back to 0 (or, a while after that, half a step up): all times are known.
RAMP = {
    "name": "ramp",
    "states": ["x"],
    "parameters": {"tau": 0.3, "jump": 0.25},
    "modes": {"up": {"x'": "1"}},
    "events": {"top": "x - 1", "later": {"after": "top", "delay": "tau"}},
    "resets": {"fall": {"x": "0"}, "rise": {"x": "x + jump"}},
    "segments": {
        "top": {"mode": "up", "event": "top", "direction": "rising", "reset": "fall", "to": "up"},
        "later": {"mode": "up", "event": "later", "reset": "rise", "to": "up"},
    },
}
# A triangle between -1 and 1, without jumps.
TRIANGLE = {
    "name": "triangle",
    "states": ["x"],
    "parameters": {},
    "modes": {"up": {"x'": "1"}, "down": {"x'": "-1"}},
    "events": {"high": "x - 1", "low": "x + 1"},
    "segments": {
        "rise": {"mode": "up", "event": "high", "direction": "rising", "to": "down"},
        "sink": {"mode": "down", "event": "low", "direction": "falling", "to": "up"},
    },
}
RAMP_PERIOD = 0.75


def numeric_of(data):
    return NumericModel(parse_model(parse_document(to_yaml(data), "m.yaml"))[0])


def ramp(t):
    """Return the state of the ramp: from 0 at t = 0, up by ``jump`` at 0.3, from 0 again at 0.75."""
    t = t % RAMP_PERIOD
    return t + 0.25 * (t >= 0.3)


def write_ramp(begin, n=12, columns="t,x", label=None):
    """Return one period of the ramp from a time on, with two rows at each jump."""
    jumps = sorted(j for k in range(9) for j in (0.3 + k * RAMP_PERIOD, k * RAMP_PERIOD))
    end = begin + RAMP_PERIOD
    rows = [(t, ramp(t)) for t in np.linspace(begin, end, n)[1:-1] if min(abs(t - j) for j in jumps) > 1e-6]
    for j in jumps:
        rows += [(j, ramp(j - 1e-12))] if begin < j <= end + 1e-9 else []
        rows += [(j, ramp(j + 1e-12))] if begin - 1e-9 <= j < end - 1e-9 else []
    rows += [(t, ramp(t)) for t in (begin, end) if min(abs(t - j) for j in jumps) > 1e-6]
    rows = sorted(rows, key=lambda row: row[0])
    after = [i == 0 or rows[i - 1][0] == t for i, (t, _) in enumerate(rows)]
    extra = [] if label is None else [label(not is_after, t) for is_after, (t, _) in zip(after, rows, strict=True)]
    lines = [",".join([repr(float(t)), repr(float(x)), *extra[i : i + 1]]) for i, (t, x) in enumerate(rows)]
    return "\n".join([columns, *lines])


def cycle_of(numeric, text, *signature, mode=None):
    table = read_motion_table(text, "orbit.csv", numeric.model)
    return find_cycle(numeric, numeric.parameter_values, table, signature, mode)


@pytest.mark.parametrize("begin", [0.0, 0.1, 0.3, 0.4, 0.7499, 5.3])
@pytest.mark.parametrize("signature", [("later", "top"), ("top", "later")])
def test_jumps_are_told_apart_by_their_events_wherever_rows_begin(begin, signature):
    cycle = cycle_of(numeric_of(RAMP), write_ramp(begin), *signature)
    assert cycle.signature == signature
    assert cycle.times[-1] - cycle.times[0] == pytest.approx(RAMP_PERIOD, abs=1e-9)
    durations = dict(zip(signature, np.diff(cycle.times), strict=True))
    assert durations == pytest.approx({"later": 0.3, "top": 0.45}, abs=1e-9)
    ends = {"later": (0.0, 0.3), "top": (0.55, 1.0)}
    for s, name in enumerate(signature):
        at = cycle.evaluate(s, cycle.times[s : s + 2])[:, 0]
        assert at == pytest.approx(ends[name], abs=1e-6)


@pytest.mark.parametrize("begin", [0.0, 0.1, 0.3, 0.4])
def test_a_column_says_where_segments_end_by_name_or_number(begin):
    numeric = numeric_of(RAMP)

    def name(i, t, names=("later", "top")):
        # Of two rows at a jump the first is the end of a segment; the first and the last row are one in this way.
        side = -1e-13 if i else 1e-13
        return names[0] if (t + side) % RAMP_PERIOD < 0.3 else names[1]

    by_name = cycle_of(numeric, write_ramp(begin, columns="t,x,segment", label=name))
    by_number = cycle_of(
        numeric, write_ramp(begin, columns="t,x,segment", label=lambda i, t: name(i, t, "12")), "later", "top"
    )
    for cycle in (by_name, by_number):
        durations = dict(zip(cycle.signature, np.diff(cycle.times), strict=True))
        assert durations == pytest.approx({"later": 0.3, "top": 0.45}, abs=1e-9)
    assert by_number.signature == ("later", "top")


def write_triangle(begin, n=15, columns="t,x", label=None):
    t = np.linspace(begin, begin + 4.0, n)
    x = np.abs((t % 4.0) - 2.0) - 1.0
    extra = [""] * n if label is None else [f",{label(s)}" for s in t]
    return "\n".join([columns, *(f"{s!r},{z!r}{e}" for s, z, e in zip(t.tolist(), x.tolist(), extra, strict=True))])


@pytest.mark.parametrize("begin", [0.0, 0.7, 2.0, 3.9])
def test_events_are_found_where_functions_cross_zero(begin):
    # Rows rarely hold the corners: what is between is cut off, and both events would be missed.
    numeric = numeric_of({**TRIANGLE, "events": {"high": "x - 0.5", "low": "x + 0.5"}})
    cycle = cycle_of(numeric, write_triangle(begin, 61), "rise", "sink")
    assert cycle.signature == ("rise", "sink")
    # x falls through -1/2 at t = 3/2 and rises through 1/2 at t = 7/2.
    assert np.diff(cycle.times) == pytest.approx([2.0, 2.0], abs=1e-3)
    assert (cycle.times[0] - 1.5) % 4.0 == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("begin", [0.1, 1.0, 2.9])
def test_between_rows_of_two_segments_one_ends_where_its_event_is(begin):
    def label(t):
        return "sink" if t % 4.0 < 2.0 else "rise"

    text = write_triangle(begin, 18, "t,x,segment", label)
    cycle = cycle_of(numeric_of(TRIANGLE), text)
    durations = dict(zip(cycle.signature, np.diff(cycle.times), strict=True))
    assert durations == pytest.approx({"rise": 2.0, "sink": 2.0}, abs=1e-9)


def test_delayed_values_are_read_from_the_motion_itself():
    # x = sin(pi t / 2), and the relay switches as x(t - 1) crosses zero: at t = 1 and 3.
    numeric = shipped("relay")
    t = np.linspace(0.2, 4.2, 41)
    text = "\n".join(["t,x", *(f"{s!r},{math.sin(0.5 * math.pi * s)!r}" for s in t.tolist())])
    cycle = cycle_of(numeric, text, "pull", "push")
    assert cycle.times % 4.0 == pytest.approx([1.0, 3.0, 1.0], abs=1e-3)


def test_times_of_forced_models_tell_the_phase_and_are_stretched_to_the_period():
    numeric = shipped("wall_oscillator")
    t = np.round(np.linspace(0.4, 0.4 + 2 * math.pi, 41), 2)
    text = "\n".join(["t,x,v", *(f"{s},{math.cos(s)!r},{-math.sin(s)!r}" for s in t)])
    cycle = cycle_of(numeric, text, mode="free")
    assert cycle.n_periods == 2
    assert cycle.times[0] == 0.4
    assert cycle.times[-1] - cycle.times[0] == pytest.approx(2 * math.pi, abs=1e-14)
    assert cycle.signature == ()
    assert cycle.mode == "free"


def change_rows(text, change):
    head, *rows = text.splitlines()
    return "\n".join([head, *change(rows)])


@pytest.mark.parametrize(
    ("make", "signature", "mode", "words"),
    [
        (lambda: write_ramp(0.1), (), None, "nothing says which segments the rows run through: give 'signature'"),
        (lambda: write_ramp(0.1), ("later", "top", "top"), None, "do not run through the signature"),
        (lambda: write_ramp(0.1), ("top",), None, r"'top' may end at t = 0.75; states jump at t = 0.3, 0.75"),
        (lambda: write_ramp(0.1), ("tip",), None, "did you mean 'top'"),
        (lambda: write_ramp(0.1), (), "up", r"states jump at t = 0.3 \(line \d+\), and a motion without events"),
        (lambda: change_rows(write_ramp(0.1), lambda r: r[:-3]), ("top", "later"), None, "The last row closes"),
        (lambda: write_ramp(0, 12, "t,x,segment", lambda i, t: "1"), (), None, "segments are numbers: give"),
        (lambda: "t,x,segment\n0,0,up\n1,1,up\n2,1,up\n3,0,top\n", (), None, "line 2: 'up' is not a segment"),
        (
            lambda: "t,x,segment\n0,0,1\n1,1,1\n1,0,3\n2,1,3\n",
            ("later", "top"),
            None,
            r"run through segments \[1, 3\], not through the signature .* line 4 begins segment '3'",
        ),
        (
            lambda: "t,x,segment\n0,0,1\n1,1,1\n1,0,2\n1.5,0.5,2\n1.5,0,1\n2,1,1\n2,0,2\n3,1,2",
            ("later", "top"),
            None,
            "line 6 begins segment '1'",
        ),
        (lambda: "t,x,segment\n0,0,1\n1,1,1\n1,0,2\n1,0,1\n2,1,1\n", ("later", "top"), None, "are all at t = 1"),
    ],
)
def test_what_does_not_fit_is_told(make, signature, mode, words):
    with pytest.raises(SignatureError, match=words):
        cycle_of(numeric_of(RAMP), make(), *signature, mode=mode)


def test_two_periods_are_not_one():
    text = "\n".join([write_triangle(0.7, 31), *(f"{t!r},{x!r}" for t, x in _later(write_triangle(0.7, 31)))])
    numeric = numeric_of({**TRIANGLE, "events": {"high": "x - 0.5", "low": "x + 0.5"}})
    with pytest.raises(SignatureError, match=r"'rise' may end at t = 3.5\d*, 7.5"):
        cycle_of(numeric, text, "rise", "sink")
    assert cycle_of(numeric, text, "rise", "sink", "rise", "sink").times[-1] > 8.0


def _later(text):
    rows = [tuple(map(float, line.split(","))) for line in text.splitlines()[1:]]
    return [(t + 4.0, x) for t, x in rows[1:]]


def test_rows_that_do_not_close_are_refused():
    numeric = shipped("wright")
    t = np.linspace(0.0, 0.8, 20)
    text = "\n".join(["t,x", *(f"{s!r},{math.sin(2 * math.pi * s)!r}" for s in t.tolist())])
    with pytest.raises(SignatureError, match=r"differs from the first by 0\.4[78] of a state's range"):
        cycle_of(numeric, text)


def test_forced_rows_span_whole_periods():
    numeric = shipped("wall_oscillator")
    text = "\n".join(["t,x,v", *(f"{s},0,1" for s in range(5))])
    with pytest.raises(SignatureError, match=r"span 1.273 periods of the forcing \(3.14159\), from t = 0 to 4"):
        cycle_of(numeric, text, "flight")
