"""Which view and which steps a picture shows when little is said."""

import pytest

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest, list_views
from pddecont.plot.view_selection import find_views, select_view
from tests.plot.synthetic import gain


def names(views):
    return [view.name for view in views]


@pytest.mark.parametrize(
    ("request_", "view", "steps"),
    [
        (ViewRequest(), "plane", ["in_gain", "doubled", "grazing", "folds"]),
        (ViewRequest("plane"), "plane", ["grazing", "folds"]),
        (ViewRequest("diagram"), "diagram", ["in_gain", "doubled"]),
        (ViewRequest("orbit"), "orbit", ["folds"]),
        (ViewRequest("multipliers"), "multipliers", ["doubled"]),
        (ViewRequest("manifold"), "manifold", ["grazing", "folds", "in_delay", "in_gain", "doubled"]),
        (ViewRequest(steps=("in_gain",)), "diagram", ["in_gain"]),
        (ViewRequest(steps=("doubled", "in_gain", "doubled")), "diagram", ["doubled", "in_gain"]),
        (ViewRequest(steps=("grazing",)), "plane", ["grazing"]),
        (ViewRequest("diagram", ("grazing",)), "diagram", ["grazing"]),
        (ViewRequest(steps=("orbit",)), "orbit", ["orbit"]),
    ],
)
def test_what_is_chosen(every, request_, view, steps):
    found, drawn = select_view(every, request_)
    assert found.name == view
    assert [s.name for s in drawn] == steps


@pytest.mark.parametrize(
    ("request_", "view", "steps"),
    [
        # The last sweep is over two parameters; a diagram of brute force stands over the branches in its parameter.
        (ViewRequest(), "sweep", ["plane"]),
        (ViewRequest("diagram"), "diagram", ["branch"]),
        (ViewRequest("sweep", ("diagram",)), "sweep", ["diagram"]),
        (ViewRequest("sweep", ("branch", "diagram")), "sweep", ["branch", "diagram"]),
        (ViewRequest("basin"), "basin", ["map", "other"]),
    ],
)
def test_what_is_chosen_of_simulations(simulated, request_, view, steps):
    test_what_is_chosen(simulated, request_, view, steps)


def test_what_is_chosen_of_comparisons(compared):
    test_what_is_chosen(compared, ViewRequest(), "precision", ["fine"])
    test_what_is_chosen(compared, ViewRequest("distance"), "distance", ["coarse", "fine"])


def test_the_views_of_a_step_by_itself(every, made):
    views = {name: names(list_views(step)) for name, step in every.steps.items()}
    assert views["orbit"] == ["orbit", "profile", "multipliers"]  # one point does not move
    assert views["grazing"][:3] == ["plane", "diagram", "manifold"]
    assert "manifold" not in views["in_gain"]  # a branch alone spans no plane
    assert "multipliers" in views["in_gain"] and "multipliers" not in views["in_delay"]
    assert list_views(made(b=([], {})).step("b")) == []


def test_a_view_that_was_named_may_need_other_steps_too(every):
    assert {"manifold", "multipliers"} <= set(names(find_views(every.step("in_delay"))))


def test_what_cannot_be_drawn(every, simulated, made):
    for results, request, message in (
        (every, ViewRequest("trajectory"), r"holds nothing to draw as trajectory \(steps: orbit, in_delay"),
        (every, ViewRequest("none"), r"holds nothing to draw as none \(steps: orbit, in_delay"),
        (every, ViewRequest("none", ("orbit",)), "it can be drawn as orbit, profile, multipliers, not as none"),
        (every, ViewRequest(steps=("grasing",)), "did you mean 'grazing'"),
        (every, ViewRequest("profile", ("orbit", "folds")), "'profile' shows one step; choose one of orbit, folds"),
        (every, ViewRequest("orbit", ("orbit", "folds")), "'orbit' shows one step"),
        (simulated, ViewRequest("sweep", ("branch",)), "needs a sweep step"),
        (made(), ViewRequest(), r"nothing to draw \(steps: none\)"),
    ):
        with pytest.raises(ResultsError, match=message):
            select_view(results, request)
    results = made(b=([], {}), later=(gain()[:1], {"kind": "orbit"}))
    with pytest.raises(ResultsError, match="step 'b' has no points yet"):
        select_view(results, ViewRequest(steps=("b",)))
    with pytest.raises(
        ResultsError, match="is an orbit step; it can be drawn as orbit, profile, multipliers, not as diagram"
    ):
        select_view(results, ViewRequest("diagram", ("later",)))
