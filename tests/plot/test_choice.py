"""Which view and which steps a picture shows when little is said."""

import pytest

from pddecont.errors import ResultsError
from pddecont.plot.choice import View, choose
from pddecont.results.reader import read_results
from pddecont.results.writer import create
from tests.plot.synthetic import add, gain


@pytest.mark.parametrize(("view", "kind", "names"), [
    (View(), "plane", ["grazing", "folds"]),
    (View("diagram"), "diagram", ["in_gain", "doubled"]),
    (View("orbit"), "orbit", ["folds"]),
    (View("multipliers"), "multipliers", ["doubled"]),
    (View("manifold"), "manifold", ["grazing", "folds", "in_delay", "in_gain", "doubled"]),
    (View(steps=("in_gain",)), "diagram", ["in_gain"]),
    (View(steps=("doubled", "in_gain", "doubled")), "diagram", ["doubled", "in_gain"]),
    (View(steps=("grazing",)), "plane", ["grazing"]),
    (View("diagram", ("grazing",)), "diagram", ["grazing"]),
    (View(steps=("orbit",)), "orbit", ["orbit"]),
])  # fmt: skip
def test_what_is_chosen(every, view, kind, names):
    found, steps = choose(every, view)
    assert found == kind
    assert [s.name for s in steps] == names


def test_what_cannot_be_drawn(every, tmp_path):
    with pytest.raises(ResultsError, match=r"holds nothing to draw as trajectory \(steps: orbit, in_delay"):
        choose(every, View("trajectory"))
    with pytest.raises(ResultsError, match="did you mean 'grazing'"):
        choose(every, View(steps=("grasing",)))
    create(tmp_path / "a.h5", "m", "r", "r", "{}")
    with pytest.raises(ResultsError, match=r"nothing to draw \(steps: none\)"):
        choose(read_results(tmp_path / "a.h5"), View())
    add(tmp_path / "a.h5", "b", [])
    with pytest.raises(ResultsError, match="step 'b' has no points yet"):
        choose(read_results(tmp_path / "a.h5"), View(steps=("b",)))
    add(tmp_path / "a.h5", "later", gain()[:1], kind="orbit")
    with pytest.raises(ResultsError, match="is an orbit step; it can be drawn as orbit, profile, multipliers, not as diagram"):
        choose(read_results(tmp_path / "a.h5"), View("diagram", ("later",)))
