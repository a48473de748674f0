"""Tables as data frames: types, values, units and words for every column."""

import math
import sys

import numpy as np
import pytest

from pddecont.errors import ResultsError
from tests.api import sample_runs

pandas = pytest.importorskip("pandas")
RUNS = ("equilibria", "orbits", "attractors", "exploration", "precision")


@pytest.mark.parametrize("name", RUNS)
def test_every_column_of_every_table_is_described_and_has_its_values(name):
    found = getattr(sample_runs, name)()
    for step in found:
        for table_name in found[step].tables:
            if table_name == "multipliers" and not found[step].point().spectrum.size:
                continue
            table = found[step].table(table_name)
            frame = table.to_pandas()
            assert list(frame.columns) == list(table.columns) == list(table.doc)
            assert frame.attrs["doc"] == table.doc
            assert frame.attrs["units"] == table.units
            assert len(frame) == len(table)
            for row, values in zip(table, frame.to_dict("records"), strict=True):
                assert all(is_same(row[key], values[key]) for key in row), (step, table_name, row, values)


def is_same(value, other):
    if value is None:
        return other is None or pandas.isna(other)
    if isinstance(value, float) and math.isnan(value):
        return math.isnan(other)
    return value == other and isinstance(other, bool) == isinstance(value, bool)


def test_types_do_not_depend_on_what_is_known():
    with_multipliers = sample_runs.orbits()["branch"].to_pandas()
    without = sample_runs.precision()["orbit"].to_pandas()
    assert without["stable"].isna().all()
    assert not with_multipliers["stable"].isna().any()
    for frame in (with_multipliers, without):
        types = {name: str(frame[name].dtype) for name in ("stable", "admissible", "verified", "n_unstable", "a")}
        assert types == {
            "stable": "boolean",
            "admissible": "boolean",
            "verified": "boolean",
            "n_unstable": "Int64",
            "a": "float64",
        }
        assert pandas.api.types.is_string_dtype(frame["label"])
        assert pandas.api.types.is_integer_dtype(frame["index"])
    multipliers = sample_runs.orbits()["branch"].to_pandas("multipliers", "EP1")
    assert multipliers["multiplier"].dtype == complex
    # A switch forgets all but its own time, so that returns to it are the same at once.
    assert abs(multipliers["multiplier"][0]) < 1e-12


def test_values_and_units_are_those_of_the_model():
    frame = sample_runs.orbits()["branch"].to_pandas()
    assert frame["top"].to_numpy() == pytest.approx(np.expm1(frame["a"].to_numpy()) / frame["a"].to_numpy())
    assert frame.attrs["units"] == {"a": "1/s", "top": "mm", "period": "s"}
    assert {key: frame.attrs[key] for key in ("step", "kind", "table", "model")} == {
        "step": "branch",
        "kind": "continue",
        "table": "points",
        "model": "relay",
    }
    assert "a = 0.6" in frame.attrs["termination"]
    roots = sample_runs.equilibria()["line"].table("roots")
    assert roots.units == {"re": "1/s", "im": "rad/s"}
    events = sample_runs.orbits()["transient"].table("events")
    assert events.units == {"t": "s", "x": "mm", "x_after": "mm"}
    assert events.doc["x_after"] == "x after the reset"


def test_an_orbit_is_arrays_and_a_data_frame():
    orbit = sample_runs.orbits()["branch"].orbit("EP1")
    assert dict(orbit).keys() == {"t", "segment", "x"}
    assert orbit["t"][-1] - orbit["t"][0] == pytest.approx(orbit.period)
    assert sorted(orbit.signature) == ["pull", "push"]
    frame = orbit.to_pandas()
    assert np.array_equal(frame["x"], orbit["x"])
    assert frame.attrs["units"] == {"t": "s", "x": "mm"}


def test_a_table_is_a_sequence_of_rows():
    table = sample_runs.orbits()["branch"].table()
    assert table[0]["label"] == "EP1"
    assert [row["index"] for row in table[1:3]] == [row["index"] for row in list(table)[1:3]]
    assert repr(table[:1]).startswith("<table 'points' of step 'branch', 1 row: index, label, kind, a,")
    assert repr(sample_runs.orbits()["orbit"].table("special")) == "<table 'special' of step 'orbit', 0 rows>"


def test_without_pandas_there_is_advice(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ResultsError, match=r"install 'pddecont\[pandas\]'"):
        sample_runs.orbits()["branch"].to_pandas()
