"""Steps that search a box for equilibria: their rows, their words, and mistakes in them."""

import numpy as np
import pytest

from pddecont.errors import ResultsError, RunError
from pddecont.model import parse_document
from pddecont.steps import load_run_plan
from pddecont.tables import describe_done
from tests.equilibrium.test_search import CHUA, DELAYED, RELAY
from tests.runs import run

BOX = {"x": [-5, 5], "y": [-5, 5], "z": [-5, 5]}


def search(model, path, box, *more, **keys):
    """Return the results of a run that searches a box, and does more steps."""
    return run({**model, "run": {"steps": [{"name": "all", "equilibrium": {"search": box, **keys}}, *more]}}, path)


def column(step, name):
    return step.points[name].tolist()


def test_rows_are_those_of_modes_first_and_then_the_virtual(tmp_path):
    step = search(CHUA, tmp_path / "r.h5", BOX).step("all")
    assert [step.labels[i] for i in step.order] == ["EQ1", "EQ2", "EQ3"]
    assert np.allclose(step.points["states"], [[-1.5, 0, 1.5], [0, 0, 0], [1.5, 0, -1.5]], atol=1e-13)
    assert column(step, "admissible") == [1, 1, 1]
    assert column(step, "n_unstable") == [2, 1, 2]
    assert describe_done(step) == "all 3 equilibria in the box"


def test_virtual_ones_come_last(tmp_path):
    step = search(RELAY, tmp_path / "r.h5", {"x": [-3, 3], "y": [-3, 3]}).step("all")
    assert [step.labels[i] for i in step.order] == ["EQ1", "EQ2", "EQ3"]
    assert np.allclose(step.points["states"], [[0, 1], [-0.5, 1.5], [1.5, -0.5]], atol=1e-13)
    assert column(step, "admissible") == [1, 0, 0]
    assert describe_done(step) == "the only equilibrium in the box; also 2 virtual ones, where their modes do not hold"


def test_a_mode_alone_is_searched_where_it_is_named(tmp_path):
    step = search(RELAY, tmp_path / "r.h5", {"x": [-3, 3], "y": [-3, 3]}, mode="x_on").step("all")
    assert np.allclose(step.points["states"], [[0, 1]], atol=1e-14)
    assert describe_done(step) == "the only equilibrium in the box"


def test_a_branch_starts_from_one_by_its_label_and_says_how_it_ended(tmp_path):
    branch = {"from": {"step": "all", "point": "EQ3"}, "free": ["alpha"], "range": {"alpha": [8.5, 9.5]}}
    step = search(CHUA, tmp_path / "r.h5", BOX, {"name": "b", "continue": branch}).step("b")
    assert np.allclose(step.points["states"], [1.5, 0, -1.5])
    text = describe_done(step)
    assert "down: reached the end of the range, alpha = 8.5; widen 'range' to go on" in text
    assert "orbit" not in text


def test_which_of_several_has_to_be_said(tmp_path):
    branch = {"from": "all", "free": ["alpha"], "range": {"alpha": [8.5, 9.5]}}
    with pytest.raises(ResultsError, match=r"holds 3 equilibria \(EQ1, EQ2, EQ3\); say which: .*point: EQ1"):
        search(CHUA, tmp_path / "r.h5", BOX, {"name": "b", "continue": branch})


def test_a_box_without_any_is_said_to_be_so_and_nothing_starts_from_it(tmp_path):
    branch = {"from": "all", "free": ["b"], "range": {"b": [1, 3]}}
    with pytest.raises(ResultsError, match=r"step 'all' of .* found no equilibrium: search in another box"):
        search(DELAYED, tmp_path / "r.h5", {"x": [1.1, 3]}, {"name": "c", "continue": branch})
    step = search(DELAYED, tmp_path / "s.h5", {"x": [1.1, 3]}).step("all")
    assert len(step) == 0
    assert describe_done(step) == "no equilibrium in the box"


def test_a_fold_is_a_place_that_is_undecided(tmp_path):
    model = {
        **DELAYED,
        "parameters": {"a": 0.25, "tau": 1.0},
        "modes": {"m": {"x'": "(x - x(t - tau)**2 - a)*(x - 2)"}},
    }
    step = search(model, tmp_path / "r.h5", {"x": [-2, 3]}).step("all")
    assert np.allclose(step.points["states"], [[2]])
    assert describe_done(step).startswith(
        "1 equilibrium in the box; WARNING: 1 place undecided, near x = 0.5; there may be more there"
    )
    (place,) = step.meta["undecided"]
    assert place["mode"] == "m"
    assert place["low"][0] <= 0.5 <= place["high"][0]


def test_a_place_beyond_the_surface_of_its_mode_leaves_no_doubt_about_others(tmp_path):
    """A double zero at x = 2 of the field that holds below 1."""
    model = {
        "name": "beyond",
        "states": ["x"],
        "parameters": {"k": 1.0},
        "equations": {"x'": "k*where(x > 1, 2 - x, (x - 2)**2)"},
        "initial": {"x": 0.0},
    }
    step = search(model, tmp_path / "r.h5", {"x": [-4, 5]}).step("all")
    assert np.allclose(step.points["states"], [[2]])
    assert describe_done(step) == (
        "the only equilibrium in the box; there may be virtual ones, where their modes do not hold"
    )


def test_a_line_of_equilibria_is_a_place_with_its_extent(tmp_path):
    """Whatever x + y is stays so."""
    model = {
        "name": "conserved",
        "states": ["x", "y"],
        "parameters": {"k": 1.0},
        "modes": {"m": {"x'": "y - k*x", "y'": "k*x - y"}},
        "initial": {"x": 1.0},
    }
    step = search(model, tmp_path / "r.h5", {"x": [0, 2], "y": [0, 3]}).step("all")
    assert len(step) == 0
    text = describe_done(step)
    assert text.startswith("no equilibria in the box; WARNING: 1 place undecided, x from 0 to 2, y from 0 to 2")
    assert text.endswith("not where equilibria meet or lie along a curve")


FILE = """name: m
states: [x, v]
parameters: {c: 0.1}
modes: {m: {x': v, v': -x - c*v}}
initial: {x: 1}
run:
  steps:
    - {name: all, equilibrium: {search: {x: [-2, 2], v: [-1, 1]}}}
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (", v: [-1, 1]", "", "m.yaml:8:41: the box has no range for v; give each state one"),
        ("v: [-1, 1]", "v: [1, -1]", "m.yaml:8:57: the range is empty: 1 is not below -1"),
        ("v: [-1, 1]", "v: [c, c]", "m.yaml:8:57: the range is empty: 0.1 is not below 0.1"),
        ("v: [-1, 1]", "w: [-1, 1], v: [-1, 1]", "m.yaml:8:54: 'w' is not a state"),
        ("v: [-1, 1]", "v: [-1]", "m.yaml:8:57: "),
        ("v: [-1, 1]", "v: [-1, q]", "m.yaml:8:62: 'q' is not defined"),
        ("v: [-1, 1]}}}", "v: [-1, 1]}, mode: n}}", "m.yaml:8:73: mode 'n' is not defined"),
        ("search:", "from: {x: 1}, search:", "'from' and 'search' exclude each other"),
        ("-x - c*v", "-x - c*cos(t)", "a forced model has no equilibria"),
    ],
)
def test_mistakes_are_found_where_they_are(old, new, message):
    text = FILE.replace(old, new)
    if "cos(t)" in new:
        text = text.replace("initial:", "forcing: {period: 2*pi}\ninitial:")
    with pytest.raises(RunError) as error:
        load_run_plan(parse_document(text, "m.yaml"))
    assert message in str(error.value)
