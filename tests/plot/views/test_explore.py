"""The picture of an exploration shows its branches, and every motion that was looked at."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest
from pddecont.plot.view_selection import select_view
from pddecont.plot.views.explore import draw_motions, find_shown, list_beside_stable, pick_steps
from pddecont.reasons import Reason
from tests.plot.drawn import legend
from tests.runs import run

MODEL = {
    "name": "two_ways",
    "states": ["x"],
    "parameters": {"a": 1, "b": 0},
    "modes": {"free": {"x'": "b + a*x - x**3"}},
    "initial": {"x": 0.5},
}


def explore(path, over):
    steps = [{"name": "all", "explore": {"over": over, "starts": 4, "check": 8}}]
    return run({**MODEL, "run": {"steps": steps}}, path)


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    return explore(tmp_path_factory.mktemp("one") / "a.h5", {"a": [-1, 2]})


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    return explore(tmp_path_factory.mktemp("two") / "a.h5", {"b": [-1, 1], "a": [-0.5, 2]})


def test_it_is_what_a_file_with_an_exploration_shows(one):
    for request in (ViewRequest(), ViewRequest(steps=("all",))):
        view, steps = select_view(one, request)
        assert view.name == "explore"
        assert [step.kind for step in steps] == [*["equilibria"] * (len(steps) - 1), "explore"]
        assert len(steps) > 2


def test_every_motion_that_settled_is_a_dot_at_its_lowest_and_highest(one, axes):
    step = one.steps["all"]
    (handle,) = draw_motions(axes, step, "a", "x")
    assert handle.get_label() == "motions that settled"
    rows = [i for i in range(len(step)) if step.reason(i).code == "explained"]
    dots = np.concatenate([line.get_xydata() for line in axes.lines])
    assert len(dots) == 2 * len(rows) == 2 * 14
    # They rest at the stable equilibria of x' = a x - x^3.
    assert dots[:, 1] ** 2 == pytest.approx(np.maximum(dots[:, 0], 0.0), abs=1e-5)


def test_what_goes_away_without_bound_leaves_the_rest_its_room(one, axes):
    step = one.steps["all"]
    highest = step.points["highest"].copy()
    (far, *_) = [i for i in range(len(step)) if step.reason(i).code == "explained"]
    shown = find_shown(step, 0)
    assert shown.all()
    highest[far] = 1e200
    away = replace(step, points={**step.points, "highest": highest})
    codes = ["unexplained" if i == far else step.reason(i).code for i in range(len(step))]
    found = find_shown(SimpleStep(away, codes), 0)
    assert np.flatnonzero(~found).tolist() == [far]


class SimpleStep:
    """A step whose reasons have other codes."""

    def __init__(self, step, codes):
        self.points, self._step, self._codes = step.points, step, codes

    def __len__(self):
        return len(self._codes)

    def reason(self, row):
        return Reason(self._codes[row], dict(self._step.reason(row).values))


def test_what_is_zero_but_for_errors_is_drawn_as_a_line(tmp_path, show):
    """Motions of x' = -x end at 1e-20 and less."""
    steps = [{"name": "all", "explore": {"over": {"a": [1, 2]}, "starts": 4, "check": 4}}]
    model = {
        "name": "d",
        "states": ["x"],
        "parameters": {"a": 1},
        "modes": {"free": {"x'": "-a*x"}},
        "initial": {"x": 1},
    }
    results = run({**model, "run": {"steps": steps}}, tmp_path / "a.h5")
    assert show(results).axes[0].get_ylim() == (-1.0, 1.0)


def test_what_is_small_in_its_units_is_not_taken_for_zero(tmp_path, show):
    """x' = b - a x rests at b / a, 1e-9 here."""
    steps = [{"name": "all", "explore": {"over": {"a": [1, 2]}, "starts": 4, "check": 4}}]
    equations = {"x'": "b - a*x"}
    small = {"name": "s", "states": ["x"], "parameters": {"a": 1, "b": 1e-9}, "modes": {"free": equations}}
    results = run({**small, "initial": {"x": 1e-9}, "run": {"steps": steps}}, tmp_path / "a.h5")
    assert show(results).axes[0].get_ylim()[1] < 2e-9


def test_an_exploration_without_branches_is_drawn(tmp_path, show):
    steps = [{"name": "all", "explore": {"over": {"a": [-1, 2]}, "starts": 4, "check": 0, "max_branches": 1}}]
    results = run({**MODEL, "run": {"steps": steps}}, tmp_path / "a.h5")
    step = results.step("all")
    alone = replace(results, steps={"all": step}, names=("all",))
    figure = show(alone, "explore")
    assert figure.axes[0].get_ylabel() == "$x$"


def test_labels_beside_what_is_stable_are_kept(one):
    step = next(s for s in one.steps.values() if s.kind == "equilibria" and "BP1" in s.labels)
    assert "BP1" in [label for label, _ in list_beside_stable(step, "a")]


def test_two_parameters_show_curves_and_what_motions_settle_to(two):
    view, steps = select_view(two, ViewRequest())
    figure = view.drawing.draw(steps, ViewRequest())
    assert {"fold", "at rest"} <= set(legend(figure))
    curve = next(s for s in two.steps.values() if s.meta.get("curve") == "LP")
    b, a = curve.points["parameters"][:, [1, 0]].T
    # Folds of b + a x - x^3: 4 a^3 = 27 b^2.
    assert 4 * a**3 == pytest.approx(27 * b**2, abs=1e-7)


def test_without_an_exploration_there_is_nothing_to_draw(one):
    with pytest.raises(ResultsError, match="needs an explore step"):
        pick_steps([one.steps["sweep"]], one)
