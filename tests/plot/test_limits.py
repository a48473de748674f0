"""What is constant but for rounding is drawn as a constant."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pddecont.plot.limits import ROUNDING, measure_size, varies, widen_axis, widen_limits
from pddecont.results import create_results, read_results
from tests.plot import synthetic
from tests.runs import run

# At each tick s is 0.3, but for rounding.
TICKS = {
    "name": "m",
    "states": ["s", "x"],
    "parameters": {"r": 2},
    "modes": {"m": {"s'": 1, "x'": "1 - x"}},
    "events": {"tick": "s - 1.3"},
    "resets": {"halve": {"x": "x/r", "s": "s - 1"}},
    "segments": {"a": {"mode": "m", "event": "tick", "direction": "rising", "reset": "halve", "to": "m"}},
    "run": {
        "steps": [
            {"name": "diagram", "sweep": {"over": {"r": [2, 3, 5]}, "section": {"event": "tick"}, "transient": 60}}
        ]
    },
}
NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)


@pytest.fixture(scope="module")
def ticks(tmp_path_factory):
    return run(TICKS, tmp_path_factory.mktemp("ticks") / "t.h5")


@pytest.fixture(scope="module")
def still(tmp_path_factory):
    """Return a branch whose orbits' second state fades to nothing, and whose monitor is a constant."""
    path = tmp_path_factory.mktemp("still") / "s.h5"
    create_results(path, "m", "r", "r", "{}")
    rows = [
        synthetic.point(float(k), K, 3, 2.0 + 1e-15 * k, kind="BP" if k == 4 else "")
        for k, K in enumerate(np.linspace(0.1, 0.5, 5))
    ]
    whole = synthetic.circle
    shapes = iter([1.0, 0.5, 0.3, 0.1, 1e-15])

    def fading(signature):
        orbit = whole(signature)
        return orbit | {"states": orbit["states"] * np.array([1.0, next(shapes)])}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(synthetic, "circle", fading)
        synthetic.add(path, "b", rows)
    return read_results(path)


def test_limits_that_hold_only_rounding_are_widened():
    assert widen_limits(0.3 - 1e-14, 0.3 + 1e-14, 0.3) == pytest.approx((0.285, 0.315))
    assert widen_limits(1.7e-15, 1.9e-15, 2.0) == pytest.approx((-0.1, 0.1))
    assert widen_limits(0.3, 0.3001, 0.3) == (0.3, 0.3001)
    assert widen_limits(0.0, 0.0, 0.0) == pytest.approx((-0.05, 0.05))
    assert varies(np.array([0.3, 0.3001, np.nan]), 0.3)
    assert not varies(np.array([0.3, 0.3 + 1e-14, np.nan]), 0.3)
    assert not varies(np.array([np.nan]), 1.0)


@given(NUMBERS, NUMBERS, st.floats(0, 1e6, allow_subnormal=False))
def test_limits_hold_what_they_held_and_lie_apart(a, b, size):
    low, high = min(a, b), max(a, b)
    size = max(size, abs(low), abs(high))
    left, right = widen_limits(low, high, size)
    assert left <= low <= high <= right
    assert right - left > ROUNDING * size
    assert widen_limits(left, right, size) == (left, right)


def test_the_size_of_what_should_be_nothing_is_that_of_the_states(still):
    step = still.step("b")
    assert measure_size([step], np.array([1e-15, np.nan])) == pytest.approx(1e-5)
    assert measure_size([step], np.array([3.0, np.inf])) == 3.0


def test_axes_that_show_more_are_left_alone(axes):
    axes.plot([0, 1], [0.3, 0.3001])
    drawn = axes.get_ylim()
    widen_axis(axes, "y", 0.3)
    assert axes.get_ylim() == drawn
    assert axes.get_autoscaley_on()


def test_a_sweep_shows_the_first_state_that_varies(ticks, show):
    step = ticks.step("diagram")
    assert step.orbits["returns"][:, 0] == pytest.approx(0.3, abs=1e-12)
    axes = show(ticks, "sweep").axes[0]
    assert axes.get_ylabel() == "$x$ at returns"
    low, high = show(ticks, "sweep", y="s").axes[0].get_ylim()
    assert (low, high) == pytest.approx((0.285, 0.315), abs=5e-3)


def test_diagrams_and_phase_plots_do_not_show_rounding(still, show):
    diagram, orbit = show(still, "diagram").axes
    assert diagram.get_ylim() == pytest.approx((1.9, 2.1))
    assert orbit.get_title().startswith("BP1")
    assert orbit.get_xlim()[1] == pytest.approx(1.0, abs=0.2)
    assert orbit.get_ylim() == pytest.approx((-0.05, 0.05), rel=0.1)
    (profile,) = show(still, "profile", y="v").axes
    assert profile.get_ylim() == pytest.approx((-0.05, 0.05), rel=0.1)
