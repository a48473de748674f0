"""A diagram by itself: what is known of it in closed form is found, whatever broke the run off."""

import numpy as np
import pytest

from pddecont.errors import ConvergenceError, RunError
from pddecont.results import read_results
from pddecont.runfile import extend_plan
from pddecont.steps import Budget, list_step_kinds
from pddecont.steps.execution import execute
from pddecont.steps.execution import explore_under_way as under_way
from pddecont.tables import describe_endings, describe_exploration_lines, list_branches, make_table
from tests.runs import change, parameter, plan, run

BALL = {
    "model": "bouncing_ball",
    "steps": [{"name": "all", "explore": {"over": {"G": [0.3, 1.2]}, "starts": 8, "check": 16}}],
}
PITCHFORK = {
    "name": "pitchfork",
    "states": ["x"],
    "parameters": {"a": 1},
    "modes": {"free": {"x'": "a*x - x**3"}},
    "initial": {"x": 0.5},
    "run": {"steps": [{"name": "all", "explore": {"over": {"a": [-1, 2]}, "starts": 4, "check": 8}}]},
}


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    return run(BALL, tmp_path_factory.mktemp("explore") / "a.h5")


def find_label(results, kind):
    """Return the values of the parameter at all points of a kind on all branches."""
    names = [row["branch"] for row in list_branches(results.steps["all"]) if row["points"]]
    steps = [results.steps[name] for name in names]
    return [parameter(step, "G", label) for step in steps for label in step.labels if label.startswith(kind)]


def holds_same(a, b):
    """Return whether two files hold the same steps, in whatever order, with the same numbers."""
    return sorted(a.names) == sorted(b.names) and all(
        np.array_equal(x, y, equal_nan=x.dtype.kind == "f")
        for name in a.names
        for group in ("points", "orbits")
        for x, y in zip(getattr(a.steps[name], group).values(), getattr(b.steps[name], group).values(), strict=True)
    )


def test_the_fold_and_the_period_doubling_of_the_ball_are_found(ball):
    r = 0.8
    fold = np.pi * (1 - r) / (1 + r)
    doubling = np.sqrt(fold**2 + 4 * (1 + r**2) ** 2 / (1 + r) ** 4)
    assert min(abs(x - fold) for x in find_label(ball, "LP")) < 1e-9
    assert min(abs(x - doubling) for x in find_label(ball, "PD")) < 1e-9


def test_nothing_is_followed_twice_and_all_that_settles_lies_on_a_branch(ball):
    step = ball.steps["all"]
    (ending,) = step.endings
    assert ending.values["n_explained"] == ending.values["n_motions"] > 10
    assert ending.values["stopped"] == ""
    kept = [row["branch"] for row in list_branches(step) if row["points"]]
    assert [name for name in ball.names if name.startswith("branch")] == kept
    periods = [float(np.median(ball.steps[name].points["period"])) / (2 * np.pi) for name in kept]
    assert len({round(x) for x in periods}) == len(periods)
    assert make_table(step, "unexplained") == []


def test_doubled_orbits_end_where_they_fall_onto_the_single_one(ball):
    rows = list_branches(ball.steps["all"])
    # None is followed to its end to be recognised as another only then.
    assert not [row for row in rows if "the same as" in row["outcome"]]
    ended = [row for row in rows if "fell onto the single orbit" in row["outcome"]]
    assert ended
    singles = {round(parameter(ball.steps["branch_1"], "G", "PD1"), 9)}
    assert {round(row["low"], 9) for row in ended if row["low"] < 1.08} <= singles


def test_branches_are_ordinary_steps(ball):
    assert ball.steps["branch_1"].kind == "continue"
    assert ball.steps["branch_1"].done
    assert ball.steps["sweep"].kind == "sweep"
    assert "branches" in describe_endings(ball.steps["all"])[0]
    assert any(
        line.startswith("branch_1, from sweep A1: G 0.349066 to 1.2")
        for line in describe_exploration_lines(ball.steps["all"])
    )


@pytest.mark.parametrize("number", [1, 3])
def test_a_run_that_was_broken_off_goes_on_to_the_same_file(ball, number, tmp_path, monkeypatch):
    path, whole = tmp_path / "a.h5", under_way.do_step
    left = [number]

    def do_some(context, step):
        if not left[0]:
            raise KeyboardInterrupt
        left[0] -= 1
        whole(context, step)

    monkeypatch.setattr(under_way, "do_step", do_some)
    with pytest.raises(KeyboardInterrupt):
        execute(plan(BALL), path)
    monkeypatch.setattr(under_way, "do_step", whole)
    assert len(read_results(path).names) == number
    execute(plan(BALL), path, resume=True)
    assert holds_same(read_results(path), ball)


class Ticks(Budget):
    """A budget whose time is over when it has been asked so often."""

    left = 0

    @property
    def is_over(self):
        Ticks.left -= 1
        return Ticks.left < 0


@pytest.mark.parametrize("ticks", [1, 2, 6, 9, 17, 40])
def test_the_time_may_be_over_amid_any_step(ball, ticks, tmp_path, monkeypatch):
    path = tmp_path / "a.h5"
    monkeypatch.setattr(Ticks, "left", ticks)
    execute(plan(BALL), path, budget=Ticks())
    results = read_results(path)
    assert not results.steps["all"].done
    assert results.steps["all"].endings[0].values["stopped"] == "time"
    assert any("--resume" in line for line in describe_exploration_lines(results.steps["all"]))
    assert len(results.names) < len(ball.names)
    execute(plan(BALL), path, resume=True)
    assert holds_same(read_results(path), ball)


@pytest.mark.parametrize("budget", [Budget(seconds=0.0), Budget(max_branches=1)])
def test_a_budget_ends_it_in_order_and_another_goes_on(ball, budget, tmp_path):
    path = tmp_path / "a.h5"
    execute(plan(BALL), path, budget=budget)
    step = read_results(path).steps["all"]
    assert not step.done
    assert step.endings[0].values["stopped"] == ("max_branches" if budget.max_branches else "time")
    assert any("--resume" in line for line in describe_exploration_lines(step))
    execute(plan(BALL), path, resume=True)
    assert holds_same(read_results(path), ball)


def test_equilibria_are_followed_through_a_pitchfork(tmp_path):
    results = run(PITCHFORK, tmp_path / "a.h5")
    step = results.steps["all"]
    assert step.endings[0].values["n_explained"] == step.endings[0].values["n_motions"] > 0
    branches = [results.steps[row["branch"]] for row in list_branches(step) if row["points"]]
    assert {b.kind for b in branches} == {"equilibria"}
    states = np.concatenate([b.points["states"][:, 0] for b in branches])
    values = np.concatenate([b.points["parameters"][:, 0] for b in branches])
    assert states * (values - states**2) == pytest.approx(0, abs=1e-8)
    assert max(states) == pytest.approx(np.sqrt(2))
    assert min(states) == pytest.approx(-np.sqrt(2))
    assert np.sum(np.abs(states) < 1e-9) > 5


def test_chaos_is_named_and_not_explained(tmp_path):
    settings = {"over": {"a": [0.15, 0.22]}, "starts": 4, "check": 4, "depth": 0, "transient": 400}
    equations = {"x'": "-y - z", "y'": "x + a*y", "z'": "0.2 + z*(x - 5.7)"}
    roessler = {"name": "r", "states": ["x", "y", "z"], "parameters": {"a": 0.2}, "modes": {"free": equations}}
    results = run({**roessler, "run": {"steps": [{"name": "all", "explore": settings}]}}, tmp_path / "a.h5")
    rows = make_table(results.steps["all"], "unexplained")
    assert any("chaotic" in row["look"] and row["lyapunov"] > 0.03 for row in rows)


# A Hopf normal form beside a forced state, coupled by a resonant term of size e: the rotation number of its torus is
# w + c a where e is zero.
TORUS = {
    "name": "born_torus",
    "states": ["x", "y", "z"],
    "parameters": {"a": 0.05, "w": np.sqrt(2) / 5, "c": 0.5, "e": 0},
    "forcing": {"period": "2*pi"},
    "definitions": {"r": "x**2 + y**2", "u": "x**2 - y**2"},
    "modes": {
        "free": {
            "x'": "a*x - (w + c*r)*y - x*r + e*(u*cos(t) + 2*x*y*sin(t))",
            "y'": "a*y + (w + c*r)*x - y*r + e*(u*sin(t) - 2*x*y*cos(t))",
            "z'": "-z + cos(t)",
        }
    },
    "initial": {"x": 0.1},
}


def explore_torus(path, parameters, **settings):
    body = {"over": {"a": [-0.1, 0.3]}, "starts": 4, "check": 4, **settings}
    model = {**TORUS, "parameters": {**TORUS["parameters"], **parameters}}
    return run({**model, "run": {"steps": [{"name": "all", "explore": body}]}}, path)


def test_a_torus_is_followed_from_its_birth_with_its_rotation_number(tmp_path):
    step = explore_torus(tmp_path / "a.h5", {}).steps["all"]
    rows = make_table(step, "tori")
    assert {row["from"] for row in rows} == {"branch_1 TR1"}
    assert len(rows) == 16
    for row in rows:
        assert "on a torus" in row["look"]
        assert row["rotation"] == pytest.approx(
            np.sqrt(2) / 5 + 0.5 * row["a"], abs=max(10 * row["rotation_error"], 1e-9)
        )
        assert row["rotation_error"] < 1e-6
        assert abs(row["lyapunov"]) < 1e-3
    assert any("rotation number 0.28" in line for line in describe_exploration_lines(step))


def test_windows_in_which_a_torus_is_locked_become_branches(tmp_path):
    results = explore_torus(tmp_path / "a.h5", {"e": 0.05})
    rows = make_table(results.steps["all"], "tori")
    assert "1/3" in {row["locked"] for row in rows}
    low, high = (f([row["a"] for row in rows if row["locked"] == "1/3"]) for f in (min, max))
    branches = [row for row in list_branches(results.steps["all"]) if row["points"]]
    (window,) = [row for row in branches if np.median(results.steps[row["branch"]].points["period"]) > 18]
    assert window["low"] <= low < high <= window["high"]
    assert "the branch is closed" in window["outcome"]
    # In coordinates that turn with 1/3 the locked motion rests, with (a - s)**2 + (w - 1/3 + c s)**2 = e**2 s where
    # s = x**2 + y**2: two such circles meet where the discriminant is zero.
    c, e = 0.5, 0.05
    nu = np.sqrt(2) / 5 - 1 / 3
    k = 2 * nu * c - e**2
    folds = sorted(np.roots([-4 * c**2, -4 * k, k**2 - 4 * (1 + c**2) * nu**2]))
    assert [window["low"], window["high"]] == pytest.approx(folds, abs=1e-7)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("over", {"H": [0, 1]}, "'H' is not a parameter"),
        ("over", {"G": [1, 0]}, "the range is empty"),
        ("box", {"z": [0, 1]}, "'z' is not a state"),
        ("transient", -1, "expected a positive time"),
        ("section", {"event": "hit"}, "'hit' is not an event"),
    ],
)
def test_what_is_wrong_is_told_before_anything_is_computed(key, value, message):
    body = {**BALL["steps"][0]["explore"], key: value}
    with pytest.raises(RunError, match=message):
        plan(change(BALL, "steps.0.explore", body))


def test_a_plan_is_extended_by_a_step_as_a_file_would_say_it():
    first = plan({"model": "wright", "steps": [{"name": "t", "simulate": {"t_end": 10}}]})
    more = extend_plan(first, list_step_kinds(), {"name": "o", "orbit": {"from": "t", "stability": True}})
    whole = plan(
        {
            "model": "wright",
            "steps": [
                {"name": "t", "simulate": {"t_end": 10}},
                {"name": "o", "orbit": {"from": "t", "stability": True}},
            ],
        }
    )
    assert [step.name for step in first.steps] == ["t"]
    assert more.describe_settings(more.steps[1]) == whole.describe_settings(whole.steps[1])
    with pytest.raises(RunError, match=r"step 'c': .*not above"):
        extend_plan(first, list_step_kinds(), {"name": "c", "orbit": {"from": "nothing"}})


def test_a_step_that_fails_is_noted_and_the_others_are_done(tmp_path, monkeypatch):
    whole = under_way.do_step

    def fail(context, step):
        if step.name == "branch_1":
            raise ConvergenceError("it does not converge")
        whole(context, step)

    monkeypatch.setattr(under_way, "do_step", fail)
    step = run(BALL, tmp_path / "a.h5").steps["all"]
    assert step.endings[0].values["n_failed"] == 1
    assert any("not followed: branch_1: it does not converge" in row["outcome"] for row in list_branches(step))
    assert step.endings[0].values["n_branches"] >= 2


def test_what_the_step_sets_holds_of_all_that_it_plans(tmp_path):
    """x' = a x - x**3 with a = 2 b c at c = 3 rests at 0 and where 6 b is the square of x."""
    model = change(PITCHFORK, "parameters", {"b": 0.1, "c": 1})
    model = change(model, "modes.free.x'", "2*b*c*x - x**3")
    step = {"name": "all", "set": {"c": "1 + 2"}, "explore": {"over": {"b": [-1, 2]}, "starts": 4, "check": 8}}
    results = run(change(model, "run.steps", [step]), tmp_path / "a.h5")
    for name in results.names:
        recorded = results.steps[name]
        column = recorded.meta["parameters"].index("c")
        assert np.all(recorded.points["parameters"][:, column] == 3.0), name
    branches = [results.steps[row["branch"]] for row in list_branches(results.steps["all"]) if row["points"]]
    assert len(branches) == 2
    for branch in branches:
        x, b = branch.points["states"][branch.order, 0], parameter(branch, "b")
        assert np.min(np.abs(np.stack([x, x**2 - 6 * b])), axis=0) == pytest.approx(np.zeros(len(b)), abs=1e-9)


def test_what_the_step_sets_holds_in_the_plane_of_two_parameters(tmp_path):
    model = change(PITCHFORK, "parameters", {"a": 0.1, "b": 0.2, "c": 1})
    model = change(model, "modes.free.x'", "c + a*x + b - x**3")
    body = {"over": {"a": [-1, 2], "b": [-0.5, 0.5]}, "starts": 4, "check": 4}
    step = {"name": "all", "set": {"c": 0}, "explore": body}
    results = run(change(model, "run.steps", [step]), tmp_path / "a.h5")
    assert "plane" in results.names
    for name in results.names:
        recorded = results.steps[name]
        column = recorded.meta["parameters"].index("c")
        assert np.all(recorded.points["parameters"][:, column] == 0.0), name


@pytest.mark.slow
def test_a_cascade_of_doublings_is_followed_with_its_universal_ratio(tmp_path):
    """Distances of doublings from one to the next shrink by Feigenbaum's constant."""
    explore = {"over": {"tau": [0.3, 1.65]}, "check": 0}
    results = run({"model": "mackey_glass", "steps": [{"name": "all", "explore": explore}]}, tmp_path / "a.h5")
    branches = [results.steps[row["branch"]] for row in list_branches(results.step("all")) if row["points"]]
    found = [float(parameter(b, "tau", label)) for b in branches for label in b.labels if label.startswith("PD")]
    places: list[float] = []
    for at in sorted(found):
        # The doubled branch ends at the same place.
        if not places or at - places[-1] > 1e-6:
            places.append(at)
        else:
            assert at - places[-1] < 1e-8
    assert len(places) >= 6
    ratios = np.diff(places)[:-1] / np.diff(places)[1:]
    assert ratios[2:] == pytest.approx(4.6692, rel=5e-3)
