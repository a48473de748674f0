"""Lines between the points of branches."""

import numpy as np
import pytest

from pddecont.plot.branch_parts import split_branch
from pddecont.plot.columns import read_column
from pddecont.plot.smooth_lines import PIECES, slice_part, smooth_branch
from tests.plot.synthetic import point


@pytest.fixture
def branch(made):
    """Return a function that makes a branch of points (arclength, K, top) and gives its step and its line."""

    def make(places, **options):
        rows = [point(s, K, 3.0, top, **{k: v[i] for k, v in options.items()}) for i, (s, K, top) in enumerate(places)]
        step = made(b=(rows, {})).step("b")
        return step, smooth_branch(step, np.vstack([read_column(step, "K"), read_column(step, "top")]))

    return make


def test_the_points_of_a_branch_are_on_its_line(every):
    for name in ("in_gain", "doubled", "grazing"):
        step = every.step(name)
        columns = np.vstack([read_column(step, "K"), read_column(step, "top")])
        line = smooth_branch(step, columns)
        assert line.shape == (2, PIECES * (len(step) - 1) + 1)
        assert np.array_equal(line[:, ::PIECES], columns[:, step.order])


def test_a_circle_of_few_points_is_round(branch):
    """The middle of a chord of 22.5 degrees lies 1.9 % inside the circle; the line is three times as near."""
    angles = np.linspace(0.0, 2.0 * np.pi, 17)
    _, line = branch([(a, np.cos(a), np.sin(a)) for a in angles])
    assert np.hypot(*line) == pytest.approx(1.0, abs=0.019 / 3)


def test_points_at_uneven_distances_do_not_make_waves(branch):
    """Chords of a length 1/4 are up to 1/128 above the curve."""
    places = np.sort(np.append(np.linspace(0.0, 3.0, 13), [1.0 + 1e-9, 2.001]))
    _, (K, top) = branch([(s, s, np.exp(-s)) for s in places])
    assert top == pytest.approx(np.exp(-K), abs=1 / 512)
    assert np.all(np.diff(top) <= 1e-12)


def test_corners_at_special_points_and_jumps_stay(branch):
    places = np.linspace(-1.0, 1.0, 11)
    half = ["NC C" if s < 0 else "NC" for s in places]
    kinds = ["GR" if s == 0 else "" for s in places]
    _, (K, top) = branch([(s, s, abs(s)) for s in places], signature=half, kind=kinds)
    assert top == pytest.approx(np.abs(K), abs=1e-12)
    _, (K, top) = branch([(s, s, float(s > 0.1)) for s in places])
    assert np.all((top >= -1e-12) & (top <= 1.0 + 1e-12))


def test_what_is_not_known_is_left_out_and_leaves_the_rest_alone(branch):
    places = np.linspace(0.0, 1.0, 6)
    _, (K, top) = branch([(s, s, np.nan if k == 5 else s) for k, s in enumerate(places)])
    assert np.isnan(top[-1])
    assert np.isfinite(top[: 4 * PIECES + 1]).all()
    assert K.tolist() == pytest.approx(np.linspace(0.0, 1.0, len(K)))


def test_each_part_is_a_slice_of_the_line(every):
    step = every.step("in_gain")
    line = smooth_branch(step, read_column(step, "K")[None])[0]
    for part in split_branch(step):
        assert np.array_equal(line[slice_part(part)][::PIECES], read_column(step, "K")[part.rows])
