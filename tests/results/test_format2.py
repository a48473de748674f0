"""Files of format 2, which held sentences, are read, exported, drawn and gone on with as those of this version.

``format2.h5`` holds the run below, ``format2_partial.h5`` what was there of it when the program was killed after the
fourth point of the branch; version 0.1.0 of the program wrote both.
"""

import json
import math
import shutil
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml

from pddecont.continuation import branch
from pddecont.plot import ViewRequest, draw_picture, list_views
from pddecont.results import StepWriter, read_results
from pddecont.results.format import FORMAT_VERSION
from pddecont.tables import list_tables, make_table
from tests.cli.test_cli import call
from tests.runs import run

HERE = Path(__file__).parent
LOOSE = {"rtol": 1e-5, "atol": 1e-7}
SETTLING = {"transient": "40*pi", "max_period": 4, **LOOSE}
RUN = {
    "name": "quick",
    "states": ["x", "v"],
    "parameters": {"omega": 2, "c": 0.1, "wall": 0.2, "r": 0.8, "K": 0.1, "tau": 0.7},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v - x + K*x(t - tau)"}},
    "events": {"hit": "x - wall"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {"flight": {"mode": "free", "event": "hit", "direction": "rising", "reset": "bounce", "to": "free"}},
    "run": {
        "mesh": {"degree": 3, "intervals": 6},
        "monitors": {"top": "max(x)", "speed": "at(flight, v)"},
        "steps": [
            {"name": "transient", "simulate": {"t_end": "40*pi", "record": {"from": "37*pi"}, **LOOSE}},
            {"name": "orbit", "orbit": {"from": "transient"}},
            {
                "name": "branch",
                "continue": {
                    "from": "orbit",
                    "free": ["wall"],
                    "range": {"wall": [0.19, 0.326]},
                    "stability": True,
                    "events_along": {"of_some_height": "wall - 0.21"},
                    "step": {"initial": 0.3, "max": 0.6},
                },
            },
            {"name": "diagram", "sweep": {"over": {"wall": [0.2, 0.95, 2]}, "lyapunov": True, **SETTLING}},
            {"name": "map", "basin": {"over": {"x": [-1, 0.1, 3], "v": [-1, 1, 2]}, **SETTLING}},
            {
                "name": "compared",
                "precision": {
                    "from": "orbit",
                    "quantities": {"fastest": "max(v)"},
                    "methods": [{"method": "direct"}, {"method": "chain", "order": 2, "n": [5, 10]}],
                    "degrees": [3],
                    "intervals": [4, 6],
                    "repeats": 1,
                },
            },
        ],
    },
}
# What a clock or the machine's memory says: no two runs have the same.
MEASURED = {"wall", "wall_low", "wall_high", "cpu", "memory"}


def find_old_step(step, n_iterations, turn, settings):
    """Return the next step along a branch by the rule of version 0.1.0."""
    factor = 1.5 if n_iterations <= 3 else 1.0 if n_iterations <= 5 else 0.5
    if math.cos(turn) < 0.95:
        factor = min(factor, 0.7)
    return float(np.clip(factor * step, settings.min, settings.max))


@pytest.fixture(scope="module", autouse=True)
def _steps_of_then():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(branch, "find_next_step", find_old_step)
        yield


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    return run(RUN, tmp_path_factory.mktemp("fresh") / "fresh.h5")


@pytest.fixture(scope="module")
def old():
    return read_results(HERE / "format2.h5")


@pytest.fixture
def partial(tmp_path):
    return Path(shutil.copy(HERE / "format2_partial.h5", tmp_path / "q.h5"))


# Columns and counts that the format did not have.
NEW = ("residual", "verified", "deviation")
# Error estimates were those of whole Newton steps then.
ESTIMATES = 0.02


def same(found, expected, rel=1e-12):
    """Whether two values of tables are the same: text exactly, numbers but for rounding; NaN where both are."""
    if isinstance(expected, float) and isinstance(found, float):
        return (math.isnan(found) and math.isnan(expected)) or found == pytest.approx(expected, rel=rel, abs=1e-12)
    if isinstance(expected, complex) and isinstance(found, complex):
        return found == pytest.approx(expected, rel=1e-12, abs=1e-12)
    return found == expected


def differences(found, expected, name):
    """Return where two lists of rows differ: (table, row, column, what is there, what should be).

    What the format did not keep is left out.
    """
    assert len(found) == len(expected), name
    kept = [[[column for column in row if column not in NEW] for row in rows] for rows in (found, expected)]
    assert kept[0] == kept[1], name
    return [
        (name, i, column, row[column], other[column])
        for i, (row, other) in enumerate(zip(found, expected, strict=True))
        for column in other
        if column not in NEW
        and not (name[0] == "compared" and column in MEASURED)
        and not same(row[column], other[column], ESTIMATES if column == "error_estimate" else 1e-12)
    ]


def list_differences(found, expected):
    """Return where any table of any step, of every orbit where it is of one, differs between two files."""
    result = []
    assert list(found.steps) == list(expected.steps)
    for name, step in expected.steps.items():
        for table in list_tables(step.kind):
            if table == "multipliers" and name == "orbit":
                continue  # not computed
            rows = range(len(step)) if table in ("orbit", "multipliers") else [None]
            for row in rows:
                tables = (make_table(results.step(name), table, row) for results in (found, expected))
                result += differences(*tables, (name, table, row))
    return result


def test_it_is_read_as_a_file_of_its_own_version(old):
    assert old.version == 2
    assert {name: (step.kind, len(step), step.done) for name, step in old.steps.items()} == {
        "transient": ("simulate", 1, True),
        "orbit": ("orbit", 1, True),
        "branch": ("continue", 7, True),
        "diagram": ("sweep", 2, True),
        "map": ("basin", 3, True),
        "compared": ("precision", 7, True),
    }
    branch = old.step("branch")
    assert [label for label in branch.labels if label] == ["EP1", "UF1", "PD1", "EP2"]
    assert (branch.reason(branch.row("UF1")).code, branch.reason(branch.row("PD1")).code) == ("user_function", "")
    assert old.step("diagram").reason(1).code == "not settled"


def test_every_table_is_that_of_a_fresh_run(old, fresh):
    assert list_differences(old, fresh) == []


def test_the_commands_say_the_same_of_both(old, fresh, tmp_path):
    told = []
    for results in (old, fresh):
        data = json.loads(call("info", results.path, "--json")[1])
        *steps, compared = data["steps"]  # how the last ended says errors that are rounding
        told.append([*steps, {key: compared[key] for key in ("name", "kind", "n_points", "done", "special")}])
        code, out, _ = call("export", results.path, "--step", "branch", "--table", "special", "--format", "json")
        assert code == 0
        told.append(json.loads(out))
    assert differences(told[0], told[2], ("all", "info", None)) == []
    assert differences(told[1], told[3], ("branch", "special", None)) == []
    assert call("report", old.path, "-o", tmp_path / "p.html")[0] == 0
    assert "of_some_height" in (tmp_path / "p.html").read_text()


def read_lines(figure):
    """Return what the lines of a figure show, panel by panel."""
    return [np.vstack([line.get_xydata() for line in axes.lines] or [np.empty((0, 2))]) for axes in figure.axes]


@pytest.mark.parametrize("name", ["transient", "orbit", "branch", "diagram", "map", "compared"])
def test_every_picture_shows_the_numbers_of_a_fresh_run(old, fresh, name):
    views = [view.name for view in list_views(fresh.step(name)) if view.name not in ("animate", "precision")]
    assert [view.name for view in list_views(old.step(name))] == [view.name for view in list_views(fresh.step(name))]
    for view in views:
        found, expected = (read_lines(draw_picture(results, ViewRequest(view, (name,)))) for results in (old, fresh))
        assert len(found) == len(expected) > 0
        for a, b in zip(found, expected, strict=True):
            assert a == pytest.approx(b, rel=1e-9, abs=1e-9, nan_ok=True), view


def read_structure(path):
    """Return a file's version, and the element type and the shape of one row of each array of its steps."""
    found = {}

    def visit(name, item):
        if isinstance(item, h5py.Dataset) and (name.count("/") > 1 or item.shape):
            found[name] = (item.dtype.str, item.shape[1:])

    with h5py.File(path) as file:
        file["steps"].visititems(visit)
        return file.attrs["format_version"], found


def test_a_run_that_was_killed_goes_on_where_it_was_and_its_file_becomes_one_of_this_version(
    partial, fresh, tmp_path, monkeypatch
):
    left = read_results(partial)
    assert (left.version, list(left.steps)) == (2, ["transient", "orbit", "branch"])
    assert (len(left.step("branch")), left.step("branch").done) == (4, False)
    assert yaml.safe_load(left.run_text) == RUN
    (tmp_path / "run.yaml").write_text(left.run_text)
    append, written = StepWriter.append, Counter()

    def counted(self, *rows):
        append(self, *rows)
        written[self.name] += 1

    monkeypatch.setattr(StepWriter, "append", counted)
    code, _, err = call("run", tmp_path / "run.yaml", "-o", partial, "--resume", "-q")
    assert code == 0, err
    assert written == {"branch": 3, "diagram": 2, "map": 3, "compared": 7}
    found = read_results(partial)
    assert found.version == FORMAT_VERSION
    assert list_differences(found, fresh) == []
    assert read_structure(partial) == read_structure(fresh.path)
    for key, values in left.step("branch").points.items():
        assert np.array_equal(found.step("branch").points[key][:4], values, equal_nan=values.dtype.kind == "f"), key


def test_a_file_that_is_done_is_only_written_as_one_of_this_version(old, fresh, tmp_path):
    path = Path(shutil.copy(old.path, tmp_path / "q.h5"))
    (tmp_path / "run.yaml").write_text(old.run_text)
    code, _, err = call("run", tmp_path / "run.yaml", "-o", path, "--resume")
    assert code == 0, err
    assert err.count("done already") == 6
    assert list_differences(read_results(path), old) == []
    assert read_structure(path) == read_structure(fresh.path)


def test_steps_that_are_not_asked_for_are_whole_in_the_file_of_this_version(old, fresh, tmp_path):
    path = Path(shutil.copy(old.path, tmp_path / "q.h5"))
    (tmp_path / "run.yaml").write_text(old.run_text)
    code, _, err = call("run", tmp_path / "run.yaml", "-o", path, "--resume", "--only", "map")
    assert code == 0, err
    assert list_differences(read_results(path), old) == []
    assert read_structure(path) == read_structure(fresh.path)
