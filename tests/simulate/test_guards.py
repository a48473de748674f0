"""Guards in simulations: which mode follows is judged by the states after the reset."""

import numpy as np
import pytest

from tests.guarded import RAMP, SATURATION, tick
from tests.runs import change, run

# Every third time that the clock ticks something else follows; the count is exact.
COUNTER = {
    "name": "counter",
    "states": ["x", "n", "c"],
    "modes": {"slow": {"x'": 1, "n'": 0, "c'": 1}, "fast": {"x'": 2, "n'": 0, "c'": 1}},
    "events": {"tick": "c - 0.1"},
    "resets": {"count": {"n": "n + 1 - 3*n*(n - 1)/2", "c": 0}},
    "segments": {
        "one": {
            "mode": "slow",
            "event": "tick",
            "direction": "rising",
            "reset": "count",
            "to": [{"when": "n >= 2", "mode": "fast"}, {"mode": "slow"}],
        },
        "other": {"mode": "fast", "event": "tick", "direction": "rising", "reset": "count", "to": "slow"},
    },
    "initial": {"mode": "slow"},
}


def simulate(mapping, t_end, tmp_path, **more):
    steps = [{"name": "s", "simulate": {"t_end": t_end, **more}}]
    return run({**mapping, "run": {"steps": steps}}, tmp_path / "a.h5").step("s")


def names_of(step):
    names = step.meta["segments"]
    return [names[k] for k in step.orbits["event_segment"]]


@pytest.mark.parametrize("method", ["explicit", "stiff"])
def test_the_way_taken_at_each_tick_is_that_of_the_exact_map(tmp_path, method):
    step = simulate(RAMP, 199.5, tmp_path, method=method)
    mode, v, expected = "feed", 0.0, []
    for _ in range(199):
        before = "tick" if mode == "feed" else "tock"
        mode, v = tick(mode, v)
        expected.append(f"{before}>{mode}")
    assert names_of(step) == expected


def test_equality_is_told_exactly(tmp_path):
    """n = 0, 1, 2, 0, ..: 'n >= 2' holds at every third tick, 'n > 2' never."""
    assert names_of(simulate(COUNTER, 1.25, tmp_path))[:7] == [
        *["one>slow", "one>fast", "other"],
        *["one>slow", "one>fast", "other"],
        "one>slow",
    ]
    never = change(COUNTER, "segments.one.to", [{"when": "n > 2", "mode": "fast"}, {"mode": "slow"}])
    assert set(names_of(simulate(never, 1.25, tmp_path))) == {"one>slow"}


def test_what_the_reset_leaves_is_judged_and_not_what_it_found(tmp_path):
    """Before the reset n is 1 less: with the condition on that the other mode would come a tick later."""
    step = simulate(COUNTER, 1.25, tmp_path)
    after = step.orbits["after"][:, 1]
    assert [name == "one>fast" for name in names_of(step)] == (after >= 2).tolist()


def test_a_sampled_delayed_value_decides(tmp_path):
    """From rest the sample passes cap once, and stays beyond: x of the linear motion 1.8 (1 - exp(-t/2))."""
    step = simulate(SATURATION, 6.5, tmp_path)
    x = lambda t: np.where(t > 0, 1.8 * (1 - np.exp(-t / 2)), 0.0)  # noqa: E731
    assert x(1 - 0.3) > 0.5
    assert names_of(step) == ["tick>capped", *["tock>capped"] * 5]


def test_sweeps_and_exponents_go_through_guards(tmp_path):
    """One tick in three feeds; a motion that starts later stays later, and others die away."""
    body = {"over": {"ramp": [0.55, 0.85, 4]}, "initial": [{"v": 0.1, "c": 0}], "transient": 60, "lyapunov": True}
    body["section"] = {"event": "tick"}
    step = run({**RAMP, "run": {"steps": [{"name": "s", "sweep": body}]}}, tmp_path / "a.h5").step("s")
    assert step.points["turn"] == pytest.approx(3.0, abs=1e-9)
    assert step.points["lyapunov"] == pytest.approx(0.0, abs=1e-6)
