"""Events at the same moment."""

import math
import re

import numpy as np

from pddecont.delay import Direct
from pddecont.simulate import Method, simulate
from pddecont.tables import describe_endings, describe_reason
from tests.conftest import numeric_from
from tests.hard.test_commensurate import bounced
from tests.runs import add_step, change, parameter, run, to_yaml

TWINS = {
    "name": "twins",
    "states": ["x", "v", "y", "w"],
    "parameters": {"shift": 0, "wall": 0.2},
    "forcing": {"period": "pi"},
    "modes": {"free": {"x'": "v", "v'": "cos(2*t) - 0.1*v - x", "y'": "w", "w'": "cos(2*t) - 0.1*w - y"}},
    "events": {"first": "x - wall", "second": "y - wall - shift"},
    "resets": {"one": {"v": "-0.8*v"}, "two": {"w": "-0.8*w"}},
    "segments": {
        "first": {"mode": "free", "event": "first", "direction": "rising", "reset": "one", "to": "free"},
        "second": {"mode": "free", "event": "second", "direction": "rising", "reset": "two", "to": "free"},
    },
    "run": {
        "mesh": {"degree": 8, "tol": 1e-10},
        "monitors": {"v_in": "at(first, v)", "w_in": "at(second, w)"},
        "steps": [{"name": "t", "simulate": {"t_end": "100*pi"}}, {"name": "o", "orbit": {"from": "t"}}],
    },
}


def test_twins_simulated(record):
    """Two equal oscillators hit equal walls at the same moments: each event happens, and neither delays the other."""
    numeric = numeric_from(to_yaml(TWINS))
    path = simulate(numeric, numeric.parameter_values, Direct(), 60 * math.pi, Method(1e-11, 1e-13))
    names = np.array(path.events.segment)
    one, two = path.events.t[names == "first"], path.events.t[names == "second"]
    assert len(one) == len(two) >= 59
    record("moments of 60 simultaneous impacts", "each other", np.max(np.abs(one - two)), 1e-10)
    end = path(60 * math.pi)
    record("state of the twins", "each other", np.max(np.abs(end[:2] - end[2:])), 1e-9)


def test_the_orbit_of_twins_is_no_motion_to_go_on_from(tmp_path, record):
    """Its states are right, but between the impacts lies a segment of no duration: it is called not admissible, and has
    no branch.
    """
    branch = {"from": "o", "free": ["wall"], "range": {"wall": [0.1, 0.3]}}
    results = run(add_step(TWINS, {"name": "c", "continue": branch}), tmp_path / "a.h5")
    step = results.step("o")
    record(
        "orbit of the twins: impact speeds",
        "exact pieces",
        np.max(np.abs(step.points["monitors"][0] - bounced(1.0, 3.07))),
        1e-10,
    )
    assert step.points["admissible"][0] == 0
    assert re.search(r"not admissible: segment 2 \(second\) has duration", describe_endings(step)[0])
    branch = results.step("c")
    assert len(branch) == 1
    assert all("segment 2 (second) vanishes" in text for text in describe_endings(branch))
    record("branch from an orbit with two events at one moment", "refused", 0, 0)


def test_a_branch_up_to_the_moment(tmp_path, record):
    """With walls at different places the impacts are apart; the branch ends where they meet, at equal walls, and says
    so.
    """
    branch = {"from": "o", "free": ["shift"], "range": {"shift": [-0.1, 0.1]}, "direction": "down"}
    apart = change(TWINS, "parameters.shift", 0.05)
    step = run(add_step(apart, {"name": "c", "continue": branch}), tmp_path / "a.h5").step("c")
    record("where the two impacts meet", "shift = 0", abs(parameter(step, "shift", "VS1")), 1e-8)
    note = describe_reason(step.reason(step.row("VS1")))
    assert "meets" in note
    v_in = step.points["monitors"][:, 0]
    record(
        "speed of the one before they meet",
        "the one alone, exact pieces",
        np.max(np.abs(v_in - bounced(1.0, 3.07))),
        1e-9,
    )
