"""Where a law that switches on past values cannot rest: said by steps that look for equilibria."""

import numpy as np
import pytest

from pddecont.errors import ConvergenceError
from pddecont.tables import describe_done
from tests.runs import run

# At rest x = c and y = d: c + d - k s = 0 with abs(s) < 1 what the relay gives on average.
LAW = {
    "name": "relay",
    "states": ["x", "y"],
    "parameters": {"a": 0.5, "c": 0.1, "k": 1.0, "tau": 1.0},
    "equations": {"x'": "a*x - k*sign(x(t - tau) - c) + y", "y'": "-y + 0.3"},
}
WORDS = "push to the surface of event 'x' from both sides, but it is crossed by past values: no rest there, but orbits"


def rest(path, steps, **parameters):
    model = {**LAW, "parameters": {**LAW["parameters"], **parameters}}
    return run({**model, "run": {"steps": steps}}, path)


def test_a_box_is_searched_for_such_places_too(tmp_path):
    steps = [{"name": "all", "equilibrium": {"search": {"x": [-1, 1], "y": [-1, 1]}}}]
    step = rest(tmp_path / "r.h5", steps).step("all")
    (place,) = step.meta["switchings"]
    assert np.allclose(place["states"], [0.1, 0.3], rtol=0, atol=1e-14)
    assert sorted(place["modes"]) == ["x_above", "x_below"]
    assert describe_done(step).startswith("no equilibrium in the box; at x = 0.1, y = 0.3 modes 'x_")
    assert WORDS in describe_done(step)


def test_there_is_none_where_one_side_wins(tmp_path):
    """The rest at x = c needs abs(a c + 0.3) < k."""
    steps = [{"name": "all", "equilibrium": {"search": {"x": [-0.5, 0.5], "y": [-1, 1]}}}]
    assert not rest(tmp_path / "r.h5", steps, k=0.34).step("all").meta["switchings"]
    assert rest(tmp_path / "s.h5", steps, k=0.36).step("all").meta["switchings"]


def test_there_is_none_where_both_sides_push_away(tmp_path):
    steps = [{"name": "all", "equilibrium": {"search": {"x": [-0.5, 0.5], "y": [-1, 1]}}}]
    assert not rest(tmp_path / "r.h5", steps, k=-1.0).step("all").meta["switchings"]


def test_without_the_delay_the_motion_rests_there(tmp_path):
    step = rest(tmp_path / "r.h5", [{"name": "rest", "equilibrium": {"from": {"x": 0.1, "y": 0.3}}}], tau=0.0).step(
        "rest"
    )
    assert not step.meta["switchings"]


def test_a_guess_from_which_no_mode_has_one_is_told_of_it(tmp_path):
    steps = [{"name": "rest", "equilibrium": {"from": {"x": 0.2}}}]
    with pytest.raises(ConvergenceError, match=f"{WORDS}, the smaller the shorter the delay. What usually helps"):
        rest(tmp_path / "r.h5", steps, a=0.0)


def test_orbits_there_are_as_small_as_the_delay_is_short(tmp_path):
    """x' = a x - sgn x(t - tau) has the amplitude (exp(a tau) - 1)/a around the place at zero."""
    model = {
        "name": "relay",
        "states": ["x"],
        "parameters": {"a": 0.5, "tau": 0.1},
        "modes": {"pull": {"x'": "a*x - 1"}, "push": {"x'": "a*x + 1"}},
        "events": {"switch": "x(t - tau)"},
        "segments": {
            "pull": {"mode": "pull", "event": "switch", "direction": "falling", "to": "push"},
            "push": {"mode": "push", "event": "switch", "direction": "rising", "to": "pull"},
        },
        "initial": {"mode": "pull", "x": 0.01},
        "run": {
            "monitors": {"swing": "amplitude(x)"},
            "steps": [
                {"name": "rest", "equilibrium": {"from": {"x": 0.1}}},
                {"name": "near", "simulate": {"t_end": 10}},
                {"name": "orbit", "orbit": {"from": "near"}},
                {
                    "name": "shrinks",
                    "continue": {"from": "orbit", "free": ["tau"], "range": {"tau": [0.01, 0.1]}, "direction": "down"},
                },
            ],
        },
    }
    results = run(model, tmp_path / "r.h5")
    assert results.step("rest").meta["switchings"][0]["states"] == [0.0]
    branch = results.step("shrinks")
    tau = branch.points["parameters"][:, 1]
    assert np.min(tau) == pytest.approx(0.01)
    assert np.allclose(branch.points["monitors"][:, 0], np.expm1(0.5 * tau) / 0.5, rtol=1e-7)
