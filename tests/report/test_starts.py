"""The run file that a page gives for a point runs, and begins at that point."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from pddecont.report import render_page
from pddecont.results import read_results
from tests.cli.test_cli import call
from tests.report.page_reader import find_data
from tests.runs import parameter, run

RUN = {
    "model": "wall_oscillator",
    "monitors": {"deepest": "min(x)"},
    "mesh": {"degree": 5, "tol": 1e-07},
    "steps": [
        {"name": "transient", "simulate": {"t_end": "60*pi"}},
        {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
        {"name": "in_r", "continue": {"from": "orbit", "free": ["r"], "range": {"r": [0.78, 0.82]}}},
        {"name": "sweep", "sweep": {"over": {"r": [0.78, 0.8, 2]}, "transient": "60*pi", "section": {"phase": 0.0}}},
    ],
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return run(RUN, tmp_path_factory.mktemp("start") / "first run.h5")


def take(results, name, place):
    """Return the run file that the page gives for a point, as its script puts it together."""
    data = find_data(render_page(results))
    step = data.step(name)
    label, index = data.column(step, "label")[place], int(data.column(step, "index")[place])
    return (f"point: {label}" if label else f"index: {index}").join(step["start"])


@pytest.mark.parametrize(("name", "place", "kind"), [("orbit", 0, "omega"), ("in_r", 0, "r"), ("in_r", 2, "r")])
def test_a_run_file_from_the_page_follows_the_point(results, monkeypatch, name, place, kind):
    folder = results.path.parent
    monkeypatch.chdir(folder)
    (folder / "next.yaml").write_text(take(results, name, place), encoding="utf-8")
    code, _, err = call("run", "next.yaml", "--overwrite", "-q")
    assert code == 0, err
    old, new = results.steps[name], read_results(folder / "next.h5").steps["from_here"]
    assert new.meta["free"] == [kind] and len(new) > 2
    row = old.order[place]
    # The first orbit of a branch is the one it starts from, on a mesh of its own.
    np.testing.assert_allclose(new.points["parameters"][0], old.points["parameters"][row], rtol=1e-9)
    np.testing.assert_allclose(new.points["monitors"][0], old.points["monitors"][row], rtol=1e-5)
    assert np.ptp(parameter(new, kind)) > 0


def test_a_run_file_from_an_attractor_solves_its_orbit(results, monkeypatch):
    folder = results.path.parent
    monkeypatch.chdir(folder)
    (folder / "next.yaml").write_text(take(results, "sweep", 0), encoding="utf-8")
    code, _, err = call("run", "next.yaml", "--overwrite", "-q")
    assert code == 0, err
    new = read_results(folder / "next.h5").steps["from_here"]
    old = results.steps["sweep"]
    np.testing.assert_allclose(new.points["parameters"][0], old.points["parameters"][0], rtol=1e-12)


def test_texts_of_a_stranger_stay_texts_in_a_run_file(results, monkeypatch):
    step = replace(results.steps["in_r"], name="a, b}: [!!python/name:os.system]")
    strange = replace(results, path=results.path.with_name("x: {y}#.h5"), steps={step.name: step})
    read = yaml.safe_load(take(strange, step.name, 0))
    [only] = read["steps"]
    assert only["continue"]["from"] == {"file": "x: {y}#.h5", "step": step.name, "point": "EP1"}
    assert read["mesh"] == {"degree": 5, "tol": 1e-7}


def test_a_model_with_its_own_run_is_named_by_its_file(results):
    own = replace(results, run_text=results.model_text, source="/home/somebody/mine.yaml")
    assert take(own, "in_r", 0).startswith("model: mine.yaml\n")
