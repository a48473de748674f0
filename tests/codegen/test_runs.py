"""Outputs that are alike are written by loops, which write what single lines would."""

import re

from hypothesis import given
from hypothesis import strategies as st

from pddecont.codegen.runs import SHORTEST, write_outputs

N = 4 * SHORTEST
ARRAYS = {"x": [100.0 + i for i in range(2 * N)], "xd": [500.0 + i for i in range(2 * N)], "c0": 7.0}
texts = st.one_of(
    st.sampled_from(["1.0", "-1", "c0", "-c0", "x[3]", "2*c0", "-x[4]"]),
    st.builds(lambda name, i: f"{name}[{i}]", st.sampled_from(["x", "xd"]), st.integers(0, N)),
)
rows = st.one_of(
    st.builds(lambda text, step, n: [(step, text)] * n, texts, st.integers(1, 5), st.integers(1, 3 * SHORTEST)),
    st.builds(
        lambda name, first, n: [(1, f"{name}[{first + i}]") for i in range(n)],
        st.sampled_from(["x", "xd"]),
        st.integers(0, N),
        st.integers(1, N),
    ),
)


def written(lines):
    out = {}
    exec("\n".join(lines), {**ARRAYS, "out": out})
    return out


@given(st.lists(rows, max_size=6))
def test_loops_write_what_single_lines_would(parts):
    entries, place = [], -1
    for gap, text in (entry for row in parts for entry in row):
        place += gap
        entries.append((place, text))
    expected = {place: eval(text, {}, ARRAYS) for place, text in entries}
    assert written(write_outputs(entries)) == expected


def test_a_part_of_an_array_is_copied():
    entries = [(i, f"x[{i}]") for i in range(SHORTEST)] + [(50 + i, f"x[{20 + i}]") for i in range(SHORTEST)]
    assert write_outputs(entries) == [
        f"for k in range(0, {SHORTEST}, 1):",
        "    out[k] = x[k]",
        f"for k in range(50, {50 + SHORTEST}, 1):",
        "    out[k] = x[k - 30]",
    ]


def test_a_number_at_even_distances_is_one_loop():
    entries = [(11 * i, "1") for i in range(SHORTEST)]
    assert write_outputs(entries) == [f"for k in range(0, {11 * (SHORTEST - 1) + 1}, 11):", "    out[k] = 1"]


def test_few_outputs_and_what_has_to_be_worked_out_are_written_one_by_one():
    for entries in ([(i, "1") for i in range(SHORTEST - 1)], [(i, "x[0]*c0") for i in range(2 * SHORTEST)]):
        assert write_outputs(entries) == [f"out[{place}] = {text}" for place, text in entries]


def test_what_lies_between_two_rows_does_not_hide_them():
    entries = [(i, "c0") if i % 2 else (i, f"x[{i}]*c0") for i in range(2 * SHORTEST)]
    lines = write_outputs(entries)
    assert lines[:2] == [f"for k in range(1, {2 * SHORTEST}, 2):", "    out[k] = c0"]
    assert all(re.fullmatch(r"out\[\d+\] = x\[\d+\]\*c0", line) for line in lines[2:])
