"""Which multipliers lie outside the unit circle along a branch, and what their changes say."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.bifurcation import BranchSettings, find_kind
from pddecont.bifurcation.multiplier_counts import (
    TEST_FUNCTIONS,
    count_crossings,
    count_on_branch,
    count_on_curve,
    count_outside,
    measure_miss,
)
from pddecont.collocation import MeshRule
from pddecont.continuation import CurvePoint, FixedUnknowns, NewtonSettings, TestFunctions
from pddecont.continuation.locate import BranchSegment
from pddecont.continuation.test_functions import evaluate_tests, find_special_points
from tests.bifurcation import runs
from tests.bifurcation.runs import BALL_PD, follow, make_multipliers, settle
from tests.continuation.systems import line
from tests.runs import labels, multipliers, parameter, run


def test_stability_along_the_ball(ball):
    """Stable between fold and doubling on one side of the fold, a saddle on the other."""
    step = ball.step("c")
    G = step.points["parameters"][:, 0]
    saddle = np.array(
        [np.max(np.abs(multipliers(step, i))) > 1 and np.max(multipliers(step, i).real) > 1 for i in range(len(step))]
    )
    ordinary = np.array([not k for k in step.points["kind"]])
    assert np.all(step.points["stable"][ordinary & ~saddle & (G < BALL_PD)] == 1)
    assert np.all(step.points["stable"][ordinary & ~saddle & (G > BALL_PD)] == 0)
    assert np.all(step.points["n_unstable"][ordinary & saddle] == 1)
    assert 3 < np.sum(saddle) < len(step) - 3


@pytest.mark.parametrize("most", [0.03, 0.25, 0.8])
def test_no_point_is_missed_or_invented_by_large_steps(tmp_path, most):
    steps = [
        *settle("200*2*pi"),
        follow("c", "o", {"G": [0.3, 1.2]}, stability=True, step={"max": most, "initial": 0.02}),
    ]
    step = run(runs.ball(steps, degree=8, tol=1e-10), tmp_path / "a.h5").step("c")
    assert sorted(labels(step)) == ["LP1", "PD1"]
    assert parameter(step, "G", "PD1") == pytest.approx(BALL_PD, abs=1e-10)


def point_with(values, tangent=1.0):
    """Return a point of a branch whose orbit has multipliers, and whose parameter changes at a rate."""
    unknowns = SimpleNamespace(free=slice(0, 1))
    orbit = SimpleNamespace(multipliers=make_multipliers(values), problem=SimpleNamespace(unknowns=unknowns))
    return SimpleNamespace(at=SimpleNamespace(orbit=orbit), tangent=np.array([tangent]))


class Recorded:
    """Finds the multipliers that an orbit says it has."""

    def find(self, orbit):
        return orbit.multipliers


def settings_for(detect=None, multipliers=True):
    return BranchSettings(("a",), ((0, 1),), MeshRule(8), Recorded() if multipliers else None, (), detect)


def explained(counts, before, after):
    """Return the labels that account for a change between two points; None if the step must be cut."""
    tests = counts.explain(counts.count(before), counts.count(after))
    return None if tests is None else [test.kind for test in tests]


def test_multipliers_outside_the_circle_are_counted_by_how_they_left_it():
    assert count_outside(make_multipliers([2.0, 1.5, -3.0, 0.5, -0.9, 1.2j, -1.2j, 0.1j, -0.1j])) == (2, 1, 1)
    assert count_outside(make_multipliers([])) == (0, 0, 0)


CROSSING = {
    "BP": ([0.9], [1.1]),
    "PD": ([-0.9, 0.2], [-1.1, 0.2]),
    "TR": ([0.9 * np.exp(1j), 0.9 * np.exp(-1j)], [1.1 * np.exp(1j), 1.1 * np.exp(-1j)]),
}


@pytest.mark.parametrize("label", CROSSING)
@pytest.mark.parametrize("way", [1, -1])
def test_one_crossing_of_the_circle_is_told_by_its_place(label, way):
    before, after = map(point_with, CROSSING[label][::way])
    counts = count_on_branch(settings_for())
    assert explained(counts, before, after) == [label]
    # Its test function changes sign there.
    (test,) = counts.explain(counts.count(before), counts.count(after))
    assert test.value(before) * test.value(after) < 0.0


@pytest.mark.parametrize("pair", [[1.2 + 0.1j, 1.2 - 0.1j], [-1.2 + 0.1j, -1.2 - 0.1j]])
def test_a_pair_that_meets_on_the_axis_outside_is_no_special_point(pair):
    real = [abs(pair[0]) * np.sign(pair[0].real)] * 2
    counts = count_on_branch(settings_for())
    assert explained(counts, point_with(pair), point_with(real)) == []
    assert explained(counts, point_with(real), point_with(pair)) == []


def test_several_crossings_at_once_must_be_told_apart():
    counts = count_on_branch(settings_for())
    assert explained(counts, point_with([0.9, -0.9]), point_with([1.1, -1.1])) is None
    assert explained(counts, point_with([0.9, 0.8]), point_with([1.1, 1.2])) is None


@pytest.mark.parametrize(("before", "after"), [([0.9], [1.1]), ([1.1], [0.9]), ([0.5], [0.5])])
def test_where_the_parameter_turns_at_most_one_multiplier_passes_one(before, after):
    counts = count_on_branch(settings_for())
    assert explained(counts, point_with(before, 1.0), point_with(after, -1.0)) == ["LP"]
    assert explained(counts, point_with([-0.9, *before], 1.0), point_with([-1.1, *after], -1.0)) is None


def test_without_multipliers_only_turns_are_counted():
    counts = count_on_branch(settings_for(multipliers=False))
    assert counts.count(point_with([5.0], -1.0)) == (0,)
    assert explained(counts, point_with([5.0], 1.0), point_with([0.0], -1.0)) == ["LP"]


def test_only_what_is_looked_for_is_explained():
    some = count_on_branch(settings_for(("PD",)))
    assert explained(some, *map(point_with, CROSSING["BP"])) == []
    assert explained(some, *map(point_with, CROSSING["PD"])) == ["PD"]
    assert explained(some, point_with([0.9], 1.0), point_with([1.1], -1.0)) == []
    assert count_on_branch(settings_for(())) is None
    assert count_on_branch(settings_for(("GR",))) is None


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.lists(st.floats(-3.0, 3.0).filter(lambda v: abs(abs(v) - 1.0) > 1e-9), max_size=5), st.integers(0, 2))
def test_test_functions_change_sign_with_the_parity_of_their_counts(real, n_pairs):
    pairs = [2j, -2j] * n_pairs + [0.5j, -0.5j]
    counts = count_outside(make_multipliers([*real, *pairs]))
    for function, count in zip(TEST_FUNCTIONS, counts, strict=True):
        value = function(make_multipliers([*real, *pairs]))
        assert math.isnan(value) or np.sign(value) == (-1.0) ** count


def test_on_a_curve_its_own_multipliers_do_not_count():
    """On a curve of doublings -1 lies now inside and now outside by rounding."""
    counts = count_on_curve(find_kind("PD"), settings_for())
    inside, outside = (point_with([-1.0 + k * 1e-9, 0.5]) for k in (1, -1))
    assert counts.count(inside) == counts.count(outside) == (0, 0, 0)
    assert explained(counts, inside, point_with([-1.0, 1.5])) == ["FF"]
    assert explained(counts, inside, point_with([-1.0, -1.5])) == ["R2"]
    assert count_on_curve(find_kind("PD"), settings_for(multipliers=False)) is None


def test_labels_of_crossings_are_those_of_the_curve():
    counts = count_crossings(("one", "two", "three"), lambda point: point.at.orbit.multipliers)
    found = [explained(counts, *map(point_with, CROSSING[label])) for label in ("BP", "PD", "TR")]
    assert found == [["one"], ["two"], ["three"]]


def find_on_a_step(values_at):
    """Return the labels, places and losses on a step of a curve of grazings with multipliers ``values_at(place)``."""
    system = FixedUnknowns(line(1.0))
    ends = [CurvePoint(system, system.at(np.full(2, value))) for value in (0.0, 1.0)]
    counts = count_crossings(("GL", "GP", "GT"), lambda point: make_multipliers(values_at(float(point.x[0]))))
    functions = TestFunctions((), counts)
    values = [evaluate_tests(end, functions) for end in ends]
    found, lost = find_special_points(BranchSegment(*ends, NewtonSettings()), functions, *values, 0.0)
    return [(special.test.kind, special.fraction) for special in found], lost


def test_a_multiplier_that_jumps_past_one_gets_no_label_beside_a_large_one():
    """The polynomial of all multipliers is as large as the largest: beside that, 0.01448 is nothing."""

    def large(s):
        return -2.0 - 1e6 * max(s - 0.5, 0.0)

    assert find_on_a_step(lambda s: [1.01448 if s < 0.5 else 0.98, large(s)]) == ([], 1)
    assert find_on_a_step(lambda s: [1.01448 - 0.03 * s, large(s)]) == ([("GL", pytest.approx(0.01448 / 0.03))], 0)


def test_a_multiplier_that_jumps_past_minus_one_gets_no_label_beside_a_large_one():
    def large(s):
        return 2.0 + 1e6 * max(s - 0.5, 0.0)

    assert find_on_a_step(lambda s: [-1.01448 if s < 0.5 else -0.98, large(s)]) == ([], 1)
    assert find_on_a_step(lambda s: [-1.01448 + 0.03 * s, large(s)]) == ([("GP", pytest.approx(0.01448 / 0.03))], 0)


def test_what_two_multipliers_that_meet_are_by_rounding_does_not_matter():
    pair = make_multipliers([1.0 + 1e-6j, 1.0 - 1e-6j])
    assert measure_miss(pair, 1.0) == pytest.approx(1e-6)
    assert measure_miss(make_multipliers([1.0 + 1e-9, 1.0 - 1e-9]), None) < 1e-8
    assert measure_miss(make_multipliers([]), -1.0) == np.inf
