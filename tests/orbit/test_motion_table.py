"""Tables of times and states: what is read, and what is wrong at which line."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.errors import RunError
from pddecont.orbit import read_motion_table
from tests.conftest import shipped

MODEL = shipped("wall_oscillator").model
ROWS = "0,0,1\n1,1,0\n2,0,-1\n3,-1,0\n"


def read(text, model=MODEL):
    return read_motion_table(text, "orbit.csv", model)


def test_columns_stand_in_any_order():
    table = read("v,segment,time,x\n1,2,0,3\n4,2,1.5,6\n7,1,2,9\n10,1,1e1,-.5\n")
    assert table.t == pytest.approx([0, 1.5, 2, 10], abs=0)
    assert table.x == pytest.approx(np.array([[3, 1], [6, 4], [9, 7], [-0.5, 10]]), abs=0)
    assert table.segment == (2, 2, 1, 1)
    assert table.line == (2, 3, 4, 5)


def test_what_other_programs_write_is_read():
    text = '\ufeff# made elsewhere\r\n"t", "x" , v, segment\r\n\r\n 0 , 0 ,1,a\r\n1,1,0,a\n#\n2,0,-1,b\n3,-1,0,2\n'
    table = read(text)
    assert table.x[0].tolist() == [0, 1]
    assert table.segment == ("a", "a", "b", "2")
    assert table.line == (4, 5, 7, 8)
    assert read("t,x,v,segment\n" + ROWS.replace("\n", ",1.000e+00\n")).segment == (1, 1, 1, 1)
    assert read("t,x,v\n" + ROWS).segment is None


def test_times_that_differ_by_rounding_are_one():
    for first, second in ((1 + 1e-15, 1.0), (1.0, 1 + 1e-15)):
        table = read(f"t,x,v\n0,0,1\n{first!r},1,0\n{second!r},0,-1\n3,-1,0\n")
        assert table.t.tolist() == [0, first, first, 3]


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("", "", "is empty"),
        ("# nothing\n\n", "", "is empty"),
        ("x,v\n" + ROWS, ":1:1", "no column 't' or 'time'; expected a line with the names of columns: t, x, v"),
        (ROWS, ":1:1", "no column 't' or 'time'"),
        ("t,x\n0,1\n", ":1:1", "no column for state 'v'"),
        ("#\nt,v,y\n", ":2:1", "no column for state 'x'"),
        ("t,x,v,x1\n", ":1:1", "column 'x1' is neither the time nor a state nor 'segment'; did you mean 'x'?"),
        ("t,time,x,v\n", ":1:1", "column 'time' is neither"),
        ("t,x,v,v\n", ":1:1", "column 'v' is there twice"),
        ("t,x,v\n0,1\n", ":2:1", "2 values, expected 3: t, x, v"),
        ("t,x,v\n0,1,2,5,3\n", ":2:1", "numbers have a decimal point"),
        ('t,x,v\n0,"1,2\n', ":2:1", "2 values, expected 3"),
        (f"t,x,v\n0,{'1' * 200_000},2\n", ":2:1", "is not a line of a CSV file"),
        ("t,x,v\n" + ROWS.replace("1,1,0", "1, one,0"), ":3:3", "finite number in column 'x', found 'one'"),
        ("t,x,v\n" + ROWS.replace("2,0,-1", "2,0,nan"), ":4:5", "finite number in column 'v', found 'nan'"),
        ("t,x,v\n" + ROWS.replace("3,-1", "3,-1_0"), ":5:3", "found '-1_0'"),
        ("t,x,v\n" + ROWS.replace("2,0,", "2,,"), ":4:3", "found ''"),
        ("t,x,v\n" + ROWS.replace("2,0,", "0.5,0,"), ":4:1", "the time 0.5 does not come after 1 above it"),
        ("t,x,v\n0,1,2\n1,2,3\n2,3,4\n", "", "has too few rows, 3"),
        ("t,x,v\n" + "5,1,2\n" * 4, "", "all rows are at the time 5"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(text, place, words):
    with pytest.raises(RunError) as caught:
        read(text)
    assert str(caught.value).startswith(f"orbit.csv{place}: ")
    assert words in str(caught.value)


def test_nothing_is_repeated_of_a_file_that_is_no_table():
    for text in ("root:x:0:0:secret\n", "secret,x,v\n1,2,3\n", "t,secret\n1,2\n"):
        with pytest.raises(RunError) as caught:
            read(text)
        assert "secret" not in str(caught.value)


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet='txvsegmn,.0123456789-e+#"\n\r\0 é_', max_size=200))
def test_any_text_is_a_table_or_an_error(text):
    for head in ("", "t,x,v\n", "t,segment,x,v\n"):
        try:
            table = read(head + text)
        except RunError as exc:
            assert len(str(exc)) < 1500
        else:
            assert np.all(np.isfinite(table.x))
            assert np.all(np.diff(table.t) >= 0)
