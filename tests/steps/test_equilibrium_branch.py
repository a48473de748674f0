"""Special points of branches of equilibria in one parameter, and what a branch cannot start from."""

import math

import numpy as np
import pytest

from pddecont.errors import ConvergenceError, ResultsError, RunError
from pddecont.tables import describe_done, describe_reason
from pddecont.tables.equilibria import list_roots, list_special_equilibria
from tests.equilibrium.hopf_models import WRIGHT
from tests.runs import labels, parameter, plan, run

# x = 0 for all r, and r = x^2 - 0.3 x: they cross at r = 0, the other one turns at x = 0.15.
CROSSING = {
    "name": "crossing",
    "states": ["x"],
    "parameters": {"r": -1.0, "tau": 0.3},
    "modes": {"m": {"x'": "r*x + 0.3*x(t - tau)**2 - x**3"}},
    "initial": {"x": 0.0},
}
# Rests at x = a below the surface x = 1, and at (a + b)/(1 + b) beyond it.
CORNER = {
    "name": "corner",
    "states": ["x"],
    "parameters": {"a": 0.5, "b": -2.0, "tau": 0.2},
    "equations": {"x'": "a - x - b*max(0, x(t - tau) - 1)"},
    "initial": {"x": 0.5},
}
RANGE = {"free": ["r"], "range": {"r": [-2, 2]}}


def follow(model, path, *steps, rest=None, free, low, high, **keys):
    """Return the results of a run that follows the equilibrium near ``rest`` in a parameter, and does more steps."""
    branch = {"from": "rest", "free": [free], "range": {free: [low, high]}, **keys}
    first = [{"name": "rest", "equilibrium": {"from": rest or {}}}, {"name": "branch", "continue": branch}]
    return run({**model, "run": {"mesh": {"degree": 5, "tol": 1e-7}, "steps": [*first, *steps]}}, path)


def count(step, label):
    """Return what is recorded of a point's unstable roots and stability."""
    row = step.row(label)
    return step.points["n_unstable"][row], step.points["stable"][row]


def test_where_equilibria_cross_and_turn(tmp_path):
    other = {"from": {"step": "branch", "point": "BP1"}, "branch": "switch", **RANGE}
    back = {"from": {"step": "other", "point": "BP1"}, "branch": "switch", **RANGE}
    results = follow(
        CROSSING,
        tmp_path / "r.h5",
        {"name": "other", "continue": other},
        {"name": "back", "continue": back},
        free="r",
        low=-2,
        high=2,
    )
    step = results.step("branch")
    assert labels(step) == ["BP1"] and parameter(step, "r", "BP1") == pytest.approx(0.0, abs=1e-13)
    # The root zero at the point itself is on neither side.
    assert count(step, "BP1") == (0, 1)
    step = results.step("other")
    r, x = parameter(step, "r"), step.points["states"][step.order][:, 0]
    assert r == pytest.approx(x**2 - 0.3 * x, abs=1e-12) and np.max(np.abs(x)) > 1
    assert sorted(labels(step)) == ["BP1", "LP1"]
    assert parameter(step, "r", "LP1") == pytest.approx(-0.0225, abs=1e-13)
    assert count(step, "LP1") == (0, 1) and count(step, "BP1") == (0, 1)
    # p Delta'(0) q = 1 + 2 0.3 x tau; the second derivative is 0.6 - 6 x = -0.3.
    assert step.points["coefficient"][step.row("LP1")] == pytest.approx(-0.15 / (1 + 0.09 * 0.3), rel=1e-10)
    assert describe_reason(step.reason(step.row("LP1"))).startswith("quadratic coefficient -0.146")
    assert np.all(results.step("back").points["states"] == pytest.approx(0.0, abs=1e-12))


@pytest.mark.parametrize(("b", "nature", "modes"), [(-2.0, "nonsmooth fold", 2), (0.5, "persistence", 2)])
def test_where_equilibria_meet_a_surface(tmp_path, b, nature, modes):
    """di Bernardo, Nordmark, Olivar (2008): for b < -1 both lie at a < 1."""
    steps = [
        {
            "name": "curve",
            "continue": {
                "from": {"step": "branch", "point": "BE1"},
                "free": ["a", "b"],
                "range": {"a": [0, 2], "b": [-3, 3]},
            },
        }
    ]
    model = {**CORNER, "parameters": {**CORNER["parameters"], "b": b}}
    results = follow(model, tmp_path / "r.h5", *steps, rest={"x": 0.5}, free="a", low=0, high=2)
    step = results.step("branch")
    assert labels(step) == ["BE1"] and parameter(step, "a", "BE1") == pytest.approx(1.0, abs=1e-13)
    assert describe_reason(step.reason(step.row("BE1"))).startswith(f"{nature}: on the surface of event")
    assert len({step.orbit(i)["signature"].tobytes() for i in range(len(step))}) == modes
    a, x = parameter(step, "a"), step.points["states"][step.order][:, 0]
    beyond = x > 1
    assert x[~beyond] == pytest.approx(a[~beyond], abs=1e-12)
    assert x[beyond] == pytest.approx((a[beyond] + b) / (1 + b), abs=1e-12)
    assert np.all(step.points["admissible"] == 1) and np.sum(beyond) > 3
    assert (np.max(a) < 1 + 1e-12) == (nature == "nonsmooth fold")
    curve = results.step("curve")
    assert parameter(curve, "a") == pytest.approx(1.0, abs=1e-13)
    assert np.ptp(parameter(curve, "b")) == 6


def test_hopf_points_and_their_roots_in_tables(tmp_path):
    """r = pi/2 + 2 pi k; at the k-th point 2 k roots are unstable besides the pair."""
    step = follow(WRIGHT.model, tmp_path / "r.h5", rest={"x": 0}, free="r", low=0.1, high=15).step("branch")
    assert labels(step) == ["HB1", "HB2", "HB3"]
    special = [row for row in list_special_equilibria(step) if row["kind"] == "HB"]
    for k, row in enumerate(special):
        expected = math.pi / 2 + 2 * math.pi * k
        assert row["r"] == pytest.approx(expected, abs=1e-12)
        assert row["frequency"] == pytest.approx(expected, abs=1e-12)
        assert (row["n_unstable"], row["stable"]) == (2 * k, k == 0)
        assert row["coefficient"] < 0 and row["note"].startswith("supercritical, frequency ")
        assert row["note"].endswith("orbits at larger r")
        roots = list_roots(step, row["index"])
        # The pair itself stands in the table.
        (own,) = [root for root in roots if abs(root["im"] - expected) < 1e-9]
        assert abs(own["re"]) < 1e-13 and own["residual"] < 1e-14
        assert all(root["residual"] < 1e-13 for root in roots) and roots[0]["number"] == 1


def test_on_from_a_hopf_point_the_branch_is_the_same(tmp_path):
    on = {"from": {"step": "branch", "point": "HB1"}, "free": ["r"], "range": {"r": [0.1, 2]}}
    results = follow(
        WRIGHT.model, tmp_path / "r.h5", {"name": "on", "continue": on}, rest={"x": 0}, free="r", low=0.1, high=3
    )
    step = results.step("on")
    assert labels(step) == ["HB1"] and step.row("HB1") == 0
    assert count(step, "HB1") == (0, 1)
    assert (
        step.points["coefficient"][0] == results.step("branch").points["coefficient"][results.step("branch").row("HB1")]
    )


def test_only_what_is_asked_for_is_looked_for(tmp_path):
    keys = {"rest": {"x": 0}, "free": "r", "low": 0.1, "high": 3}
    assert labels(follow(WRIGHT.model, tmp_path / "a.h5", **keys, detect=[]).step("branch")) == []
    assert labels(follow(WRIGHT.model, tmp_path / "b.h5", **keys, detect=["LP", "BP"]).step("branch")) == []
    assert labels(follow(WRIGHT.model, tmp_path / "c.h5", **keys, detect=["HB"]).step("branch")) == ["HB1"]


@pytest.mark.parametrize(
    ("steps", "error", "message"),
    [
        (
            [{"name": "c", "continue": {"from": "rest", "free": ["r", "tau"], "range": {"r": [0, 2], "tau": [0, 2]}}}],
            RunError,
            r"step 'c': it has two free parameters: it follows a special point \(LP, HB, BE\) and cannot start from",
        ),
        (
            [{"name": "c", "continue": {"from": "rest", "free": ["r"], "range": {"r": [0, 2]}, "branch": "switch"}}],
            RunError,
            "'branch: switch' leads from an HB point to orbits and from a BP point to the other equilibria; found",
        ),
        (
            [{"name": "c", "continue": {"from": "rest", "free": ["r"], "range": {"r": [2, 3]}}}],
            RunError,
            "starts at r = 1.5, outside",
        ),
        (
            [
                {
                    "name": "c",
                    "continue": {"from": {"step": "rest", "point": "HB1"}, "free": ["r"], "range": {"r": [0, 2]}},
                }
            ],
            ResultsError,
            "step 'rest' has no point 'HB1'",
        ),
        (
            [{"name": "c", "continue": {"from": "rest", "free": ["r"], "range": {"r": [0, 2]}, "detect": ["PD"]}}],
            RunError,
            r"'PD' is not found with one free parameter \(there are: LP, HB, BP, BE\)",
        ),
        ([{"name": "o", "orbit": {"from": "rest"}}], (RunError, ResultsError), "rest"),
    ],
)
def test_what_a_branch_cannot_start_from_is_said(tmp_path, steps, error, message):
    made = {**WRIGHT.model, "run": {"steps": [{"name": "rest", "equilibrium": {"from": {"x": 0}}}, *steps]}}
    with pytest.raises(error, match=message):
        run(made, tmp_path / "r.h5")


def test_a_forced_model_has_no_equilibria_and_is_told_what_to_do():
    model = {
        "name": "forced",
        "states": ["x"],
        "parameters": {"w": 1.0},
        "forcing": {"period": "2*pi/w"},
        "modes": {"m": {"x'": "cos(w*t) - x"}},
        "initial": {"x": 0},
        "run": {"steps": [{"name": "rest", "equilibrium": {"from": {"x": 0}}}]},
    }
    with pytest.raises(RunError, match=r"a forced model has no equilibria.*(simulate|orbit)"):
        plan(model)


def test_a_guess_from_which_nothing_is_found_says_what_helps(tmp_path):
    model = {**CROSSING, "modes": {"m": {"x'": "1 + x**2 + 0*r*x(t - tau)"}}}
    with pytest.raises(ConvergenceError, match=r"no equilibrium near the guess.*What usually helps"):
        run({**model, "run": {"steps": [{"name": "rest", "equilibrium": {"from": {"x": 1}}}]}}, tmp_path / "r.h5")


def test_states_that_grow_thousandfold_do_not_shorten_the_steps(tmp_path):
    """r = (x^3 - 6 x^2 + 9.3 x)/20 begins at x = 0 and has its folds at 2 -+ sqrt(0.9)."""
    model = {
        "name": "growth",
        "states": ["x"],
        "parameters": {"r": 0.001},
        "equations": {"x'": "r - (x**3 - 6*x**2 + 9.3*x)/20"},
    }
    steps = [
        {"name": "rest", "equilibrium": {"from": {"x": 0.002}}},
        {"name": "in_r", "continue": {"from": "rest", "free": ["r"], "range": {"r": [0, 1]}}},
    ]
    step = run({**model, "run": {"steps": steps}}, tmp_path / "r.h5").step("in_r")
    x = step.points["states"][:, 0]
    assert np.min(x) < 1e-10 and np.max(x) > 4.9
    assert len(step) < 150
    assert sorted(x[step.points["kind"] == b"LP"]) == pytest.approx([2 - np.sqrt(0.9), 2 + np.sqrt(0.9)], abs=1e-10)


@pytest.mark.parametrize(
    ("equations", "stable", "words"),
    [
        # Roots +-i, and of x'(t) = -pi/2 x(t - 1) +-i pi/2.
        ({"x'": "v", "v'": "-x", "z'": "-z"}, -1, "do not tell whether it is stable"),
        ({"x'": "-pi/2*x(t - 1)"}, -1, "do not tell whether it is stable"),
        ({"x'": "v", "v'": "-x - 1e-9*v"}, 1, "stable, leading root"),
        ({"x'": "v", "v'": "-x + 1e-9*v"}, 0, "unstable (2 roots"),
        # One that grows decides, whatever lies on the axis.
        ({"x'": "v", "v'": "-x", "z'": "z"}, 0, "unstable (1 root"),
    ],
)
def test_roots_on_the_axis_do_not_tell_stability(tmp_path, equations, stable, words):
    states = [name.rstrip("'") for name in equations]
    model = {"name": "axis", "states": states, "parameters": {"b": 0.5}, "equations": equations}
    steps = [
        {"name": "rest", "equilibrium": {"from": {}}},
        {"name": "along", "continue": {"from": "rest", "free": ["b"], "range": {"b": [0, 1]}}},
    ]
    results = run({**model, "run": {"steps": steps}}, tmp_path / "a.h5")
    assert results.step("rest").points["stable"].tolist() == [stable]
    assert results.step("rest").points["n_unstable"][0] == (0 if stable else int(words[10]))
    assert set(results.step("along").points["stable"].tolist()) == {stable}
    assert words in describe_done(results.step("rest"))
