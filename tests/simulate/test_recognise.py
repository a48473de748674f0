"""What is said of motions that never become periodic."""

import pytest

from pddecont.errors import SignatureError
from tests.runs import run_model

REST = "the motion comes to rest: the trajectory settles to an equilibrium"
SMOOTH = """name: m
states: [x, v]
parameters: {c: 0.2, k: 1}
modes: {m: {x': v, v': 1 - c*v - k*x}}
initial: {x: 2}
"""
RUN = """run:
  steps:
    - {name: t, simulate: {t_end: T_END}}
    - {name: o, orbit: {from: t}}
"""
WALL = """events: {hit: x + 0.1}
resets: {b: {v: -0.8*v}}
segments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}
"""
ZERO = ("1 - c*v", "-c*v")


@pytest.mark.parametrize(("changes", "more", "t_end", "message"), [
    ([], "", 400, REST),  # at x = 1
    ([ZERO], "", 400, REST),  # at zero, in ever smaller oscillations of one shape
    ([ZERO, ("c: 0.2", "c: 3")], "", 400, REST),  # at zero, without an oscillation
    ([ZERO], WALL, 400, REST),  # after the last impact
    ([ZERO], WALL, 5, "too few events to see a period in them; raise 't_end'"),
    ([ZERO, ("c: 0.2", "c: 0.02")], "", 60, "has not settled to a periodic motion"),
])  # fmt: skip
def test_a_motion_that_comes_to_rest_is_told_from_one_that_is_on_its_way(tmp_path, changes, more, t_end, message):
    text = SMOOTH
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    with pytest.raises(SignatureError, match=message):
        run_model(text + more + RUN.replace("T_END", str(t_end)), tmp_path / "a.h5")


def test_an_oscillation_far_smaller_than_its_transient_is_no_rest(tmp_path):
    """A Hopf normal form whose cycle has radius 1e-4 and period 2 pi, begun at 1."""
    text = """name: m
states: [x, y]
parameters: {r: 1e-4}
modes:
  m: {x': "(r**2 - x**2 - y**2)*x*1e6 - y", y': "(r**2 - x**2 - y**2)*y*1e6 + x"}
initial: {x: 200*r}
"""
    results = run_model(text + RUN.replace("T_END", "600"), tmp_path / "a.h5")
    assert results.step("o").points["period"][0] == pytest.approx(6.283185307, abs=1e-6)
