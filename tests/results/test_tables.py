"""Tables and summaries against what was put into the file."""

import csv
import io
import json

import numpy as np
import pytest
from click.testing import CliRunner

from pddecont.cli import group
from pddecont.cli.export import to_csv
from pddecont.errors import ResultsError
from pddecont.reasons import make_reason
from pddecont.results import create_results, read_results
from pddecont.tables import (
    describe_done,
    list_tables,
    make_arrays,
    make_dataset,
    make_table,
    read_multipliers,
    read_roots,
)
from pddecont.tables.summary import shorten_signature, summarise, summarise_step
from tests.plot import equilibria
from tests.plot.synthetic import add, gain, point, write_all, write_old


@pytest.fixture(scope="module")
def every(tmp_path_factory):
    return read_results(write_all(tmp_path_factory.mktemp("every") / "every.h5"))


@pytest.fixture(scope="module")
def old(tmp_path_factory):
    return read_results(write_old(tmp_path_factory.mktemp("old") / "old.h5"))


@pytest.fixture(scope="module")
def resting(tmp_path_factory):
    return read_results(equilibria.write_resting(tmp_path_factory.mktemp("resting") / "resting.h5"))


def command(*args):
    result = CliRunner().invoke(group, [str(a) for a in args], catch_exceptions=False, standalone_mode=False)
    return result.output


def test_points_keep_their_columns_in_order_with_the_new_ones_after_the_error(every):
    rows = make_table(every.step("in_gain"), "points")
    assert list(rows[0]) == [
        "index",
        "label",
        "kind",
        "omega",
        "K",
        "tau_d",
        "period",
        "stable",
        "admissible",
        "top",
        "error_estimate",
        "n_unstable",
        "note",
        "n_unknowns",
    ]
    assert [r["n_unstable"] for r in rows] == [sum(abs(m) > 1 for m in r["multipliers"]) for r in gain()]
    assert rows[0]["note"] == ""


def test_a_note_and_an_unknown_count(tmp_path):
    create_results(tmp_path / "a.h5", "m", "r", "r", "{}")
    add(
        tmp_path / "a.h5",
        "b",
        [point(0.0, 1, 3, 1, kind="UF", reason=make_reason("text", text="touches é"), stable=-1)],
    )
    [row] = make_table(read_results(tmp_path / "a.h5").step("b"), "special")
    assert (row["label"], row["note"], row["n_unstable"]) == ("UF1", "touches é", None)


def test_files_without_the_new_columns_give_the_same_table(old):
    rows = make_table(old.step("in_gain"), "points")
    assert {(r["n_unstable"], r["note"]) for r in rows} == {(None, "")}
    with pytest.raises(ResultsError, match="run it with 'stability: true'"):
        make_table(old.step("in_gain"), "multipliers")
    assert len(read_multipliers(old.step("in_gain"), 0)) == 0


def test_multipliers_one_row_each(every):
    rows = make_table(every.step("in_gain"), "multipliers")
    assert len(rows) == 33 * 3
    assert list(rows[0]) == ["index", "label", "K", "number", "multiplier", "modulus", "residual"]
    for k, row in enumerate(rows):
        expected = gain()[k // 3]["multipliers"][k % 3]
        assert row["multiplier"] == expected
        assert row["modulus"] == abs(expected)
        assert row["number"] == k % 3 + 1
    assert {r["label"] for r in rows} == {"", "LP1", "GR1"}
    moduli = np.array([r["modulus"] for r in rows]).reshape(-1, 3)
    assert np.all(np.diff(moduli, axis=1) <= 1e-15)


def test_multipliers_of_one_point(every):
    step = every.step("in_gain")
    rows = make_table(step, "multipliers", step.row("GR1"))
    assert [r["label"] for r in rows] == ["GR1"] * 3
    assert rows[0]["K"] == pytest.approx(0.5)
    with pytest.raises(ResultsError, match="33 points, no index 33"):
        make_table(step, "multipliers", 33)
    with pytest.raises(ResultsError, match=r"has no table 'events' \(it has: points, special, orbit, multipliers\)"):
        make_table(step, "events")


def test_export_of_complex_numbers(every):
    data = json.loads(
        command("export", every.path, "--step", "in_gain", "--table", "multipliers", "--index", "0", "--format", "json")
    )
    expected = gain()[0]["multipliers"]
    assert [r["multiplier"] for r in data] == [[m.real, m.imag] for m in expected]
    assert "re" not in data[0]
    text = command("export", every.path, "--step", "in_gain", "--table", "multipliers", "--label", "LP1")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert list(rows[0]) == ["index", "label", "K", "number", "re", "im", "modulus", "residual"]
    assert [complex(float(r["re"]), float(r["im"])) for r in rows] == list(gain()[8]["multipliers"])


def test_export_takes_the_last_step_that_has_multipliers(every, old):
    rows = list(csv.DictReader(io.StringIO(command("export", every.path, "--table", "multipliers"))))
    assert len(rows) == 12
    assert {float(r["re"]) for r in rows} == {-0.4}
    with pytest.raises(ResultsError, match="step 'in_gain' has no multipliers"):
        command("export", old.path, "--table", "multipliers")


def test_a_parameter_may_be_called_re():
    assert to_csv([{"re": 100.0, "multiplier": 1 + 2j}]) == "re,multiplier_re,multiplier_im\n100.0,1.0,2.0\n"


def test_a_curves_table_names_both_parameters(tmp_path):
    create_results(tmp_path / "a.h5", "m", "r", "r", "{}")
    add(tmp_path / "a.h5", "c", [point(0.0, 1, 3, 1, multipliers=[1.0])], free=("tau_d", "K"), curve="LP")
    [row] = make_table(read_results(tmp_path / "a.h5").step("c"), "multipliers")
    assert (row["tau_d"], row["K"]) == (3.0, 1.0)


def test_summary_of_stability_signatures_and_curves(every, old):
    branch = summarise_step(every.step("in_gain"))
    assert branch["stability"] == {"stable": 8, "unstable": 25, "unknown": 0}
    assert branch["signatures"] == ["NC C", "NC"]
    assert not {"trivial_error", "warning", "curve"} & set(branch)
    curve = summarise_step(every.step("grazing"))
    assert (curve["curve"], curve["free"]) == ("GR", ["tau_d", "K"])
    assert not {"stability", "trivial_error", "warning", "curve"} & set(summarise_step(old.step("in_gain")))
    assert [s["name"] for s in summarise(every)["steps"]][-1] == "folds"


@pytest.mark.parametrize(("error", "warned"), [(9e-5, False), (2e-4, True)])
def test_a_wrong_trivial_multiplier_is_warned_of(tmp_path, error, warned):
    create_results(tmp_path / "a.h5", "m", "r", "r", "{}")
    errors = [1e-9, np.nan, error]
    add(tmp_path / "a.h5", "b", [point(float(k), 1, 3, 1, trivial_error=e) for k, e in enumerate(errors)])
    data = summarise_step(read_results(tmp_path / "a.h5").step("b"))
    assert data["trivial_error"] == error
    assert ("warning" in data) == warned
    text = command("info", tmp_path / "a.h5")
    assert f"trivial_error: {error:.6g}" in text
    assert ("WARNING: the trivial multiplier is off by 0.0002 at index 2" in text) == warned


def test_info_in_words(every):
    text = command("info", every.path)
    assert "curve: GR (grazing)" in text
    assert "signatures: NC C, NC\n" in text
    assert "signatures: (NC C)×2\n" in text
    assert "unstable: 25" in text
    data = json.loads(command("info", every.path, "--json"))
    assert next(s for s in data["steps"] if s["name"] == "doubled")["signatures"] == ["NC C NC C"]


@pytest.mark.parametrize(
    ("names", "short"),
    [
        ("", ""),
        ("NC", "NC"),
        ("NC C", "NC C"),
        ("NC NC NC", "NC×3"),
        ("NC C NC C NC", "(NC C)×2 NC"),
        ("a b b a b b", "(a b b)×2"),
        ("a b b c", "a b×2 c"),
    ],
)
def test_short_signatures(names, short):
    assert shorten_signature(names) == short


def test_long_signatures_are_cut_in_the_middle():
    text = " ".join(f"segment_{k}" for k in range(30))
    short = shorten_signature(text)
    assert short.startswith("segment_0 ")
    assert short.endswith("segment_29 (30 segments)")
    assert len(short) < 65
    assert "segments" not in shorten_signature("one_very_long_name_of_the_only_segment_there_is")


def test_a_file_that_is_not_hdf5_is_told_so(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text("name: m\n")
    with pytest.raises(ResultsError, match="it is not HDF5; results files are made with 'pddecont run'"):
        read_results(path)


def test_equilibria_have_tables_of_their_own(resting):
    assert list_tables("equilibria") == list_tables("equilibrium") == ["points", "special", "roots"]
    points = make_table(resting.step("resting"), "points")
    assert [row["x"] for row in points] == pytest.approx(np.linspace(0.1, 0.9, 33))
    assert [row["mode"] for row in points] == ["low"] * 17 + ["high"] * 16
    assert [row["label"] for row in make_table(resting.step("resting"), "special")] == ["HB1", "BE1"]
    roots = make_table(resting.step("resting"), "roots", resting.step("resting").row("HB1"))
    assert [(row["number"], row["re"], row["im"], row["K"]) for row in roots] == [
        (k, pytest.approx(z.real), z.imag, 0.3) for k, z in enumerate((1j, -1j, -2.3, -1000.0), 1)
    ]
    assert command("export", resting.path, "--table", "roots", "--step", "one").splitlines() == [
        "index,label,number,re,im,residual",
        "0,EQ1,1,0.2,0.0,0.0",
        "0,EQ1,2,-1.0,0.0,0.0",
    ]


def test_equilibria_are_arrays_and_a_data_set(resting):
    step = resting.step("resting")
    arrays = make_arrays(step)
    assert arrays["x"] == pytest.approx(arrays["K"])
    pytest.importorskip("xarray")
    data = make_dataset(step)
    assert list(data.sizes.items()) == [("point", 33), ("number", 4)]
    assert np.array_equal(data["root"].values, np.array([read_roots(step, i) for i in step.order]))
    assert set(data.coords) == {"label", "K"}
    assert "multiplier" not in data


def test_a_summary_of_equilibria_names_modes(resting):
    data = summarise_step(resting.step("resting"))
    assert data["modes"] == ["low", "high"]
    assert data["stability"] == {"stable": 9, "unstable": 24, "unknown": 0}
    assert "signatures" not in data
    assert (summarise_step(resting.step("hopf"))["curve name"], data["special"]) == ("Hopf", ["HB1", "BE1"])
    assert "modes: low, high\n" in command("info", resting.path)


def test_equilibria_whose_stability_is_not_known_are_warned_of(tmp_path):
    create_results(tmp_path / "a.h5", "m", "r", "r", "{}")
    equilibria.write(tmp_path / "a.h5", "b", [equilibria.rest(k, 1.0, 0.0, [-1.0], counted=k > 0) for k in range(3)])
    step = read_results(tmp_path / "a.h5").step("b")
    assert summarise_step(step)["stability"] == {"stable": 2, "unstable": 0, "unknown": 1}
    warning = "at 1 of the points a count of the characteristic roots to the right of the imaginary axis"
    assert summarise_step(step)["warning"].startswith(warning)
    assert f"WARNING: {warning}" in describe_done(step)
