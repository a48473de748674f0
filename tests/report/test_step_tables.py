"""Tables of a report show what varies in rows, what stays once, and values plainly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pddecont.report.step_tables import build_tables, format_value, is_number
from pddecont.results import create_results, read_results
from tests.plot import equilibria, synthetic


@pytest.fixture(scope="module")
def every(tmp_path_factory):
    path = tmp_path_factory.mktemp("tables") / "a.h5"
    create_results(path, "m", "r", "r", "{}")
    synthetic.add(path, "orbit", synthetic.gain()[:1], kind="orbit")
    synthetic.add(path, "in_gain", synthetic.gain())
    synthetic.add(path, "in_delay", [synthetic.point(float(k), 0.3, 3.0 + k, 1.0) for k in range(2)], free=("tau_d",))
    synthetic.add(path, "nothing_yet", [])
    synthetic.add_precision(path, "compared", 0.2, 2.0)
    return read_results(path)


def test_special_points_are_in_words_without_what_stays(every):
    (title, rows), (other, [fixed]) = build_tables(every.step("in_gain"))
    assert (title, other) == ("Special points", "Other parameters")
    assert [(row["label"], row["kind"], row["K"]) for row in rows] == [
        ("LP1", "fold", pytest.approx(0.3)),
        ("GR1", "grazing", pytest.approx(0.5)),
    ]
    assert fixed == {"omega": 0.8, "tau_d": 3.8}
    assert not {"omega", "tau_d", "note"} & set(rows[0])


def test_other_steps_have_their_own_tables(every):
    titles = {step.name: [title for title, _ in build_tables(step)] for step in every.steps.values()}
    assert titles == {
        "orbit": ["Points", "Other parameters"],
        "in_gain": ["Special points", "Other parameters"],
        "in_delay": [],
        "nothing_yet": [],
        "compared": ["Settings compared"],
    }


def test_values_are_written_plainly():
    assert format_value(None) == format_value(float("nan")) == ""
    assert format_value(1 / 3) == "0.33333333"
    assert (format_value(True), format_value(False), format_value(3)) == ("yes", "no", "3")
    assert format_value({"a<": [1, 2], "b": None}) == "a< 1, 2; b "
    assert [is_number(value) for value in (1, 1.5, np.float64(2), True, "1", None)] == [True, True, True] + [False] * 3


@given(st.floats(allow_nan=False))
def test_numbers_keep_eight_digits(value):
    assert float(format_value(value)) == pytest.approx(value, rel=1e-7)


def test_equilibria_have_tables_with_their_roots(tmp_path):
    step = read_results(equilibria.write_resting(tmp_path / "a.h5"))
    (first, rows), (_, fixed), (last, roots) = build_tables(step.step("all"))
    assert (first, last) == ("Equilibria", "Characteristic roots")
    assert [(row["label"], row["kind"], row["mode"], row["x"]) for row in rows] == [
        ("EQ1", "equilibrium", "low", -1.0),
        ("EQ2", "equilibrium", "low", 0.0),
        ("EQ3", "equilibrium", "high", 1.0),
    ]
    # What was not computed of any of them has no column.
    assert not {"frequency", "coefficient", "note"} & set(rows[0])
    assert fixed == [{"omega": 0.8, "K": 0.2, "tau_d": 3.8}]
    assert [(row["label"], row["re"], row["im"]) for row in roots][:2] == [("EQ1", -0.1, 1.0), ("EQ1", -0.1, -1.0)]
    (title, rows), _ = build_tables(step.step("resting"))
    assert (title, [row["kind"] for row in rows]) == ("Special points", ["Hopf", "boundary equilibrium"])
