"""No delay is negative: neither what a file sets, nor what a branch leads to."""

import numpy as np
import pytest

from pddecont.errors import RunError
from pddecont.model import parse_document
from pddecont.runfile import Overrides, write_run
from pddecont.steps import load_run_plan
from pddecont.tables import describe_endings
from tests.runs import add_step, change, parameter, run

LINEAR = {
    "name": "m",
    "states": ["x"],
    "parameters": {"K": 0.5, "tau": 0.5, "b": 1},
    "forcing": {"period": "2*pi"},
    "modes": {"only": {"x'": "-x + cos(t)"}},
    "initial": {"x": 0},
    "run": {
        "mesh": {"degree": 6, "tol": 1e-07},
        "monitors": {"top": "max(x)"},
        "steps": [{"name": "transient", "simulate": {"t_end": 100}}, {"name": "orbit", "orbit": {"from": "transient"}}],
    },
}
END = "reached a limit of the model (delay '{}' becomes negative beyond {} = {})"


def linear(step, delay="tau"):
    """Return the model with a step more, and the delay of a name."""
    model = change(LINEAR, "modes.only", {"x'": f"-x + K*x(t - ({delay})) + cos(t)"})
    return add_step(model, {"name": "c", **step})


# Places in a file are those of its text.
TEXT = """name: m
states: [x]
parameters: {K: 0.5, tau: 0.5, b: 1}
forcing: {period: 2*pi}
modes: {only: {x': -x + K*x(t - tau) + cos(t)}}
initial: {x: 0}
run:
  mesh: {degree: 6, tol: 1e-7}
  monitors: {top: max(x)}
  steps:
    - {name: transient, simulate: {t_end: 100}}
    - {name: orbit, orbit: {from: transient}}
    - STEP
"""


@pytest.mark.parametrize(
    ("step", "place", "message"),
    [
        (
            "{name: c, set: {tau: -0.3}, orbit: {from: orbit}}",
            "13:28",
            "the delay tau is -0.3 at tau = -0.3; expected a non-negative number",
        ),
        (
            "{name: c, set: {tau: -0.3}, simulate: {t_end: 9}}",
            "13:28",
            "the delay tau is -0.3 at tau = -0.3; expected a non-negative number",
        ),
        (
            "{name: c, set: {tau: -0.3}, continue: {from: orbit, free: [K], range: {K: [0, 1]}}}",
            "13:28",
            "the delay tau is -0.3",
        ),
        (
            "{name: c, sweep: {over: {tau: [-0.3, 1, 5]}, initial: [{x: 0}], transient: 9}}",
            "13:31",
            "the delay tau is -0.3",
        ),
    ],
)
def test_a_step_with_a_negative_delay_is_refused_at_its_place(step, place, message):
    with pytest.raises(RunError) as caught:
        load_run_plan(parse_document(TEXT.replace("STEP", step), "m.yaml"))
    assert str(caught.value).startswith(f"m.yaml:{place}: {message}")


def test_the_command_line_sets_no_negative_delay():
    with pytest.raises(
        RunError, match=r"^--set tau=-0\.5: the delay tau is -0\.5 at tau = -0\.5; expected a non-negative number$"
    ):
        load_run_plan(write_run(linear({"orbit": {"from": "orbit"}}), None, {}), Overrides((("tau", "-0.5"),)))


def test_what_a_step_takes_from_its_start_counts(tmp_path):
    """With the run's b the delay tau - b + 1 would be negative at tau = -0.5, with that of the orbit it starts from it
    is not.
    """

    def model(tau):
        whole = linear({"set": {"tau": tau}, "orbit": {"from": "orbit"}}, "tau - b + 1")
        return change(whole, "run.steps.1", {"name": "orbit", "set": {"b": 0.25}, "orbit": {"from": "transient"}})

    results = run(model(-0.5), tmp_path / "a.h5")
    assert parameter(results.step("c"), "tau") == -0.5
    with pytest.raises(
        RunError, match=r"step 'c': the delay -b \+ tau \+ 1 is -0\.25 at b = 0\.25, tau = -1; expected"
    ):
        run(model(-1), tmp_path / "a.h5")


@pytest.mark.parametrize(
    ("low", "delay", "free", "zero"),
    [
        (-0.4, "tau", "tau", 0),
        (0, "tau", "tau", 0),
        (-0.4, "b*tau - 0.25*tau", "b", 0.25),
        (-1, "b**2*tau - 0.25*tau", "b", 0.5),
    ],
)
def test_a_branch_ends_where_a_delay_is_zero(tmp_path, low, delay, free, zero):
    """There x' = (K - 1) x + cos(t), whose maximum is 1 / sqrt(1 + (1 - K)**2)."""
    branch = {"from": "orbit", "free": [free], "range": {free: [low, 1.3]}, "stability": True, "direction": "down"}
    results = run(linear({"continue": branch}, delay), tmp_path / "a.h5")
    found = results.step("c")
    assert describe_endings(found) == [f"down: {END.format(delay, free, zero)}"]
    assert np.min(parameter(found, free)) == parameter(found, free, "EP1") == pytest.approx(zero, abs=1e-12)
    assert found.points["monitors"][found.row("EP1"), 0] == pytest.approx(1 / np.hypot(1, 0.5), abs=1e-6)
    assert np.all(found.points["stable"])


def test_a_branch_that_starts_at_delay_zero_goes_up_only(tmp_path):
    branch = {"from": "orbit", "free": ["tau"], "range": {"tau": [-1, 1]}, "stability": True}
    found = run(linear({"set": {"tau": 0}, "continue": branch}), tmp_path / "a.h5").step("c")
    assert describe_endings(found)[0] == f"down: {END.format('tau', 'tau', 0)}"
    assert describe_endings(found)[1].startswith("up: reached the end of the range")
    assert np.min(parameter(found, "tau")) == 0


def test_a_curve_ends_where_a_delay_is_zero(tmp_path):
    """A period doubling of an orbit that hits a wall, in the delay and the forcing: its condition is made of
    multipliers.
    """
    text = {
        "name": "pend",
        "states": ["th", "w"],
        "parameters": {"omega": 0.8, "c": 0.1, "A": 0.9, "K": 0.1, "tau": 0.05, "s": 0.3, "r": 0.7},
        "forcing": {"period": "2*pi/omega"},
        "modes": {"swing": {"th'": "w", "w'": "-c*w - sin(th) + A*cos(omega*t) + K*(th(t - tau) - th)"}},
        "events": {"hit": "th - s"},
        "resets": {"bounce": {"w": "-r*w"}},
        "segments": {
            "swing": {"mode": "swing", "event": "hit", "direction": "rising", "reset": "bounce", "to": "swing"}
        },
        "initial": {"th": -0.1},
        "run": {
            "mesh": {"degree": 5, "tol": 1e-05},
            "steps": [
                {"name": "transient", "set": {"A": 0.5}, "simulate": {"t_end": "100*2*pi/omega"}},
                {"name": "orbit", "orbit": {"from": "transient"}},
                {
                    "name": "in_A",
                    "continue": {
                        "from": "orbit",
                        "free": ["A"],
                        "range": {"A": [0.4, 1]},
                        "direction": "up",
                        "stability": True,
                    },
                },
                {
                    "name": "pd",
                    "continue": {
                        "from": {"step": "in_A", "point": "PD1"},
                        "free": ["tau", "A"],
                        "range": {"tau": [0.01, 0.1], "A": [0.05, 1]},
                        "stability": True,
                        "direction": "down",
                        "step": {"max": 0.2},
                    },
                },
                {
                    "name": "pd0",
                    "continue": {
                        "from": {"step": "in_A", "point": "PD1"},
                        "free": ["tau", "A"],
                        "range": {"tau": [-1, 0.1], "A": [0.05, 1]},
                        "stability": True,
                        "direction": "down",
                        "step": {"max": 0.2},
                    },
                },
            ],
        },
    }
    results = run(text, tmp_path / "a.h5")
    assert describe_endings(results.step("pd"))[0].startswith("down: reached the end of the range")
    assert parameter(results.step("pd"), "tau", "EP1") == pytest.approx(0.01, abs=1e-12)
    assert describe_endings(results.step("pd0"))[0].startswith("down: " + END.format("tau", "tau", 0))
    assert parameter(results.step("pd0"), "tau", "EP1") == pytest.approx(0, abs=1e-12)
