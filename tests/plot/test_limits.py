"""What is constant but for rounding is drawn as a constant."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from pddecont.plot.animate import _limits
from pddecont.plot.choice import View
from pddecont.plot.figure import picture
from pddecont.plot.limits import varies, widen, widened
from pddecont.results.reader import read_results
from pddecont.results.writer import create
from tests.plot import synthetic
from tests.runs import run_model

# At each tick s is 0.3, but for rounding.
TICKS = ("name: m\nstates: [s, x]\nparameters: {r: 2}\nmodes: {m: {s': 1, x': 1 - x}}\nevents: {tick: s - 1.3}\n"
         "resets: {halve: {x: x/r, s: s - 1}}\nsegments: {a: {mode: m, event: tick, direction: rising, reset: halve, to: m}}\n"
         "run: {steps: [{name: diagram, sweep: {over: {r: [2, 3, 5]}, section: {event: tick}, transient: 60}}]}\n")  # fmt: skip


@pytest.fixture(scope="module")
def ticks(tmp_path_factory):
    return run_model(TICKS, tmp_path_factory.mktemp("ticks") / "t.h5")


@pytest.fixture(scope="module")
def still(tmp_path_factory):
    """Return a branch of orbits, the second state of which is there no more at its special point, and whose monitor is a constant."""
    path = tmp_path_factory.mktemp("still") / "s.h5"
    create(path, "m", "r", "r", "{}")
    rows = [synthetic.point(float(k), K, 3, 2.0 + 1e-15 * k, kind="BP" if k == 4 else "") for k, K in enumerate(np.linspace(0.1, 0.5, 5))]
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
    assert widened(0.3 - 1e-14, 0.3 + 1e-14, 0.3) == pytest.approx((0.285, 0.315))
    assert widened(1.7e-15, 1.9e-15, 2.0) == pytest.approx((-0.1, 0.1))
    assert widened(0.3, 0.3001, 0.3) == (0.3, 0.3001)
    assert widened(0.0, 0.0, 0.0) == pytest.approx((-0.05, 0.05))
    assert varies(np.array([0.3, 0.3001, np.nan]), 0.3)
    assert not varies(np.array([0.3, 0.3 + 1e-14, np.nan]), 0.3)
    assert _limits(np.array([1.7e-15, 1.9e-15]), 2.0) == pytest.approx((-0.11, 0.11))


def test_axes_that_show_more_are_left_alone():
    axes = Figure().subplots()
    axes.plot([0, 1], [0.3, 0.3001])
    drawn = axes.get_ylim()
    widen(axes, "y", 0.3)
    assert axes.get_ylim() == drawn
    assert axes.get_autoscaley_on()


def test_a_sweep_shows_the_first_state_that_varies(ticks):
    step = ticks.step("diagram")
    assert step.orbits["returns"][:, 0] == pytest.approx(0.3, abs=1e-12)
    axes = picture(ticks, View("sweep")).axes[0]
    assert axes.get_ylabel() == "$x$ at returns"
    low, high = picture(ticks, View("sweep", y="s")).axes[0].get_ylim()
    assert (low, high) == pytest.approx((0.285, 0.315), abs=5e-3)


def test_diagrams_and_phase_plots_do_not_show_rounding(still):
    diagram, orbit = picture(still, View("diagram")).axes
    assert diagram.get_ylim() == pytest.approx((1.9, 2.1))
    assert orbit.get_title().startswith("BP1")
    assert orbit.get_xlim()[1] == pytest.approx(1.0, abs=0.2)
    assert orbit.get_ylim() == pytest.approx((-0.05, 0.05), rel=0.1)
    (profile,) = picture(still, View("profile", y="v")).axes
    assert profile.get_ylim() == pytest.approx((-0.05, 0.05), rel=0.1)
