"""Where a branch changes its look: at the special point itself, whatever that point says of itself."""

from itertools import pairwise

import numpy as np
import pytest

from pddecont.plot.stretches import Family, family, stretches
from pddecont.results.reader import read_results
from pddecont.results.writer import create
from tests.plot.synthetic import add, point


def branch(tmp_path, rows):
    path = tmp_path / "a.h5"
    create(path, "m", "r", "r", "{}")
    add(path, "b", rows)
    return read_results(path).step("b")


def test_stretches_follow_one_another_and_cover_the_branch(every):
    step = every.step("in_gain")
    found = stretches(step)
    assert [(s.style, s.family.signature, len(s.rows)) for s in found] == [
        ("-", "C NC", 9), ("--", "C NC", 9), ("--", "NC", 12), (":", "NC", 6)]  # fmt: skip
    assert all(a.rows[-1] == b.rows[0] for a, b in pairwise(found))
    assert found[0].rows[0] == step.order[0]
    assert found[-1].rows[-1] == step.order[-1]


@pytest.mark.parametrize("own", [0, 1])
def test_a_special_point_says_nothing_of_its_sides(tmp_path, own):
    rows = [point(float(k), k, 3, 0, kind="LP" if k == 2 else "", stable=own if k == 2 else int(k < 2), admissible=own if k == 2 else 1)
            for k in range(5)]  # fmt: skip
    assert [(s.style, list(s.rows)) for s in stretches(branch(tmp_path, rows))] == [("-", [0, 1, 2]), ("--", [2, 3, 4])]


def test_unknown_stability_is_drawn_solid_and_end_points_count(tmp_path):
    rows = [point(0.0, 0, 3, 0, stable=-1), point(1.0, 1, 3, 0, stable=-1), point(2.0, 2, 3, 0, stable=0, kind="EP")]
    assert [s.style for s in stretches(branch(tmp_path, rows))] == ["-", "--"]


def test_a_branch_of_one_point(tmp_path):
    [only] = stretches(branch(tmp_path, [point(0.0, 0, 3, 0, stable=0)]))
    assert (only.style, list(only.rows)) == ("--", [0])


def test_a_family_does_not_depend_on_where_the_signature_begins(tmp_path):
    step = branch(tmp_path, [point(float(k), k, 3, 0, signature=s) for k, s in enumerate(["NC C NC2", "C NC2 NC", "NC2 C NC"])])
    assert family(step, 0) == family(step, 1) == Family("C NC2 NC", 1)
    assert family(step, 2) != family(step, 0)


def test_rows_are_taken_in_order_along_the_branch(tmp_path):
    step = branch(tmp_path, [point(a, a, 3, 0) for a in (0.0, 2.0, -1.0)])
    [only] = stretches(step)
    assert np.array_equal(step.points["arclength"][only.rows], [-1, 0, 2])


def test_nothing_joins_orbits_of_different_numbers_of_periods(tmp_path):
    rows = [point(float(k), k, 3, 0, n_periods=2 if k < 2 else 1, kind="PD" if k == 2 else "") for k in range(4)]
    assert [(s.family.n_periods, list(s.rows)) for s in stretches(branch(tmp_path, rows))] == [(2, [0, 1]), (1, [2, 3])]
