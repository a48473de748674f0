"""Equilibria from Python alone, without a file: against Wright's equation's closed form."""

import numpy as np
import pytest

import pddecont
from pddecont.errors import ResultsError
from tests.api.sample_runs import WRIGHT, equilibria, exploration, orbits


def test_a_hopf_point_is_its_closed_form():
    line = equilibria()["line"]
    point = line.point("HB1")
    assert point.parameters["K"] == pytest.approx(np.pi / 2, abs=1e-9)
    assert point.values["frequency"] == pytest.approx(np.pi / 2, abs=1e-9)
    assert point.state == {"x": 0.0}
    assert sorted(point.spectrum[:2].imag) == pytest.approx([-np.pi / 2, np.pi / 2])
    assert point.kind == "Hopf"
    assert "stable" not in repr(point)
    assert [p.label for p in line.special_points()] == list(line.labels) == ["EP1", "HB1", "EP2"]


def test_both_equilibria_are_found_and_shown():
    rest = equilibria()["rest"]
    assert sorted(row["x"] for row in rest.table()) == [-1.0, 0.0]
    assert repr(rest.point("EQ1")) == "<point EQ1 of step 'rest', equilibrium, unstable>"
    assert rest.views == ("diagram", "roots")
    assert rest.tables == ("points", "special", "roots")


def test_from_the_hopf_point_orbits_branch_off():
    # Near the Hopf point the period is 2 pi / frequency = 4.
    steps = [
        {"name": "rest", "equilibrium": {"from": {"x": 0}}},
        {"name": "line", "continue": {"from": "rest", "free": ["K"], "range": {"K": [1, 2]}}},
        {
            "name": "born",
            "continue": {
                "from": {"step": "line", "point": "HB1"},
                "branch": "switch",
                "free": ["K"],
                "range": {"K": [1.5, 1.62]},
            },
        },
    ]
    found = pddecont.run(WRIGHT, steps=steps, monitors={"top": "max(x)"})
    table = found["born"].to_pandas()
    smallest = table.loc[table["top"].idxmin()]
    assert smallest["period"] == pytest.approx(4.0, abs=1e-3)
    assert np.all(table["K"] >= np.pi / 2 - 1e-6)


def test_the_picture_and_the_page_of_a_run_that_no_file_holds(tmp_path):
    found = equilibria()
    assert not found.path.exists()
    assert found.plot(view="roots", steps=["line"]).axes
    found.report(tmp_path / "page.html", beside=[exploration()])
    text = (tmp_path / "page.html").read_text()
    assert "HB1" in text and "branch_2" in text
    with pytest.raises(ResultsError, match=r"a report is \.html"):
        found.report(tmp_path / "page.pdf")


def test_several_results_are_in_one_picture_of_a_size(tmp_path):
    figure = orbits().plot(steps=["branch"], size="85mm")
    assert figure.get_size_inches()[0] == pytest.approx(85 / 25.4)
    paths = [tmp_path / "a.h5", tmp_path / "b.h5"]
    steps = [
        {"name": "rest", "equilibrium": {"from": {"x": 0}}},
        {"name": "line", "continue": {"from": "rest", "free": ["K"], "range": {"K": [1, 2]}}},
    ]
    a, b = (pddecont.run(WRIGHT, steps=steps, output=path) for path in paths)
    texts = {text.get_text() for text in a.plot(beside=[b]).legends[0].get_texts()}
    assert {"a", "b"} <= texts


def test_what_a_step_does_not_hold_is_a_results_error():
    with pytest.raises(ResultsError, match="holds no equilibria"):
        _ = orbits()["branch"].point("EP1").state
    with pytest.raises(ResultsError, match="holds no orbits"):
        equilibria()["line"].point("HB1").orbit()
    with pytest.raises(ResultsError, match="points, no index 99"):
        equilibria()["line"].point(99)
    with pytest.raises(ResultsError, match="has no table 'points'"):
        orbits()["transient"].point()
