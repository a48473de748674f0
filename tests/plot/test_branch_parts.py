"""Where a branch changes its look: at the special point itself, whatever that point says of itself."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pddecont.plot.branch_parts import Family, find_family, rotate_signature, split_branch
from tests.plot.synthetic import point

SEGMENTS = st.lists(st.sampled_from(["NC", "C", "stick", "NC2"]), min_size=1, max_size=8)


@pytest.fixture
def branch(made):
    return lambda rows: made(b=(rows, {})).step("b")


def test_parts_follow_one_another_and_cover_the_branch(every):
    step = every.step("in_gain")
    parts = split_branch(step)
    assert [(part.style, part.family.signature, len(part.rows)) for part in parts] == [
        ("-", "C NC", 9),
        ("--", "C NC", 9),
        ("--", "NC", 12),
        (":", "NC", 6),
    ]
    assert all(a.rows[-1] == b.rows[0] for a, b in pairwise(parts))
    assert parts[0].rows[0] == step.order[0]
    assert parts[-1].rows[-1] == step.order[-1]


@pytest.mark.parametrize("own", [0, 1])
@pytest.mark.parametrize("kind", ["LP", "ZZ"])
def test_a_special_point_says_nothing_of_its_sides(branch, own, kind):
    rows = [
        point(
            float(k),
            k,
            3,
            0,
            kind=kind if k == 2 else "",
            stable=own if k == 2 else int(k < 2),
            admissible=own if k == 2 else 1,
        )
        for k in range(5)
    ]
    assert [(part.style, list(part.rows)) for part in split_branch(branch(rows))] == [
        ("-", [0, 1, 2]),
        ("--", [2, 3, 4]),
    ]


def test_unknown_stability_is_drawn_solid_and_end_points_count(branch):
    rows = [point(0.0, 0, 3, 0, stable=-1), point(1.0, 1, 3, 0, stable=-1), point(2.0, 2, 3, 0, stable=0, kind="EP")]
    assert [part.style for part in split_branch(branch(rows))] == ["-", "--"]


def test_a_branch_of_one_point(branch):
    [only] = split_branch(branch([point(0.0, 0, 3, 0, stable=0)]))
    assert (only.style, list(only.rows)) == ("--", [0])


def test_a_family_does_not_depend_on_where_the_signature_begins(branch):
    signatures = ["NC C NC2", "C NC2 NC", "NC2 C NC"]
    step = branch([point(float(k), k, 3, 0, signature=s) for k, s in enumerate(signatures)])
    assert find_family(step, 0) == find_family(step, 1) == Family("C NC2 NC", 1)
    assert find_family(step, 2) != find_family(step, 0)


@given(SEGMENTS, st.integers(0, 7))
def test_all_rotations_of_a_signature_are_one(names, k):
    k %= len(names)
    rotated = rotate_signature(" ".join(names))
    assert rotate_signature(" ".join(names[k:] + names[:k])) == rotated
    assert rotated.split() in [names[i:] + names[:i] for i in range(len(names))]
    assert rotate_signature(rotated) == rotated


def test_no_signature_has_no_rotation():
    assert rotate_signature("") == ""


def test_rows_are_taken_in_order_along_the_branch(branch):
    step = branch([point(a, a, 3, 0) for a in (0.0, 2.0, -1.0)])
    [only] = split_branch(step)
    assert np.array_equal(step.points["arclength"][only.rows], [-1, 0, 2])


def test_nothing_joins_orbits_of_different_numbers_of_periods(branch):
    rows = [point(float(k), k, 3, 0, n_periods=2 if k < 2 else 1, kind="PD" if k == 2 else "") for k in range(4)]
    assert [(part.family.n_periods, list(part.rows)) for part in split_branch(branch(rows))] == [
        (2, [0, 1]),
        (1, [2, 3]),
    ]
