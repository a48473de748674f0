"""Slopes along branches, from stored tangents."""

import numpy as np
import pytest
import yaml

from pddecont.plot.columns import read_column
from pddecont.plot.heights import read_heights
from pddecont.plot.slopes import read_columns_with_slopes, read_slopes, turn_slopes
from pddecont.plot.smooth_lines import smooth_branch
from tests.runs import run

# x'' + x'/5 + x + x^3 = F cos(omega t): its response bends over, and folds twice.
DUFFING = {
    "model": "duffing",
    "monitors": {"top": "max(x)"},
    "steps": [
        {"name": "transient", "simulate": {"t_end": "40*2*pi/omega"}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {"name": "coarse", "continue": {"from": "orbit", "free": ["omega"], "range": {"omega": [0.6, 2.6]}}},
    ],
}


@pytest.fixture(scope="module")
def response(tmp_path_factory):
    """Return a branch of few points, and one of steps an eighth as long."""
    coarse, fine = (dict(DUFFING["steps"][2], name=name) for name in ("coarse", "fine"))
    coarse["continue"] = coarse["continue"] | {"step": {"max": 0.2}}
    fine["continue"] = fine["continue"] | {"step": {"max": 0.025}}
    results = run(DUFFING | {"steps": [*DUFFING["steps"][:2], coarse, fine]}, tmp_path_factory.mktemp("d") / "d.h5")
    return results.step("coarse"), results.step("fine")


def measure_distances(line, points):
    """Return how far points (2, n) are from a line (2, m), each coordinate in parts of the points' extent."""
    size = np.ptp(points, axis=1)[:, None]
    starts, pieces = (line / size)[:, :-1], np.diff(line / size, axis=1)
    found = []
    for point in (points / size).T[:, :, None]:
        share = np.clip(np.sum((point - starts) * pieces, axis=0) / np.sum(pieces**2, axis=0), 0.0, 1.0)
        found.append(np.min(np.hypot(*(point - starts - share * pieces))))
    return np.array(found)


@pytest.mark.parametrize("name", ["x", "period"])
def test_lines_of_stored_slopes_are_nearer_to_the_branch(response, name):
    coarse, fine = response
    points = np.vstack([read_column(fine, "omega"), read_heights(fine, name)[0]])[:, fine.order]
    columns = np.vstack([read_column(coarse, "omega"), read_heights(coarse, name)[0]])
    slopes = np.vstack([read_slopes(coarse, "omega"), read_slopes(coarse, name)[:1]])
    straight = measure_distances(columns[:, coarse.order], points)
    shaped, stored = (measure_distances(smooth_branch(coarse, columns, s), points) for s in (None, slopes))
    assert np.max(stored) < 0.35 * np.max(shaped)
    assert np.max(stored) < 0.06 * np.max(straight)


def test_slopes_are_those_of_the_columns(response):
    """Central differences of points h apart are off by h^2/6 times the third derivative."""
    _, fine = response
    along = fine.points["arclength"][fine.order]
    for name in ("omega", "period", "x"):
        columns, slopes = (read(fine, name)[:, fine.order] for read in (read_heights, read_slopes))
        differences = np.gradient(columns, along, axis=1)
        turned = turn_slopes(slopes, columns, along)
        inner = slice(5, -5)
        size = np.max(np.abs(differences[:, inner]), axis=1)[:, None]
        assert np.median(np.abs(turned - differences)[:, inner] / size) < 2e-3
    assert not read_slopes(fine, "F").any()
    assert np.isnan(read_slopes(fine, "top")).all()


def test_equilibria_have_the_slopes_of_their_states(tmp_path):
    model = {
        "name": "pitchfork",
        "states": ["x"],
        "parameters": {"m": -1.0, "c": 0.1},
        "equations": {"x'": "m*x - x**3 + c"},
    }
    steps = [
        {"name": "rest", "equilibrium": {"from": {"x": 0.1}}},
        {"name": "branch", "continue": {"from": "rest", "free": ["m"], "range": {"m": [-1, 1]}}},
    ]
    (tmp_path / "pitchfork.yaml").write_text(yaml.safe_dump(model))
    file = str(tmp_path / "pitchfork.yaml")
    step = run({"model": file, "steps": steps}, tmp_path / "p.h5").step("branch")
    (m, x), (dm, dx) = read_columns_with_slopes(step, "m", "x")
    # m = x^2 - c/x on the branch.
    known = np.isfinite(dm)
    assert np.count_nonzero(known) > 5
    assert dm[known] == pytest.approx((dx * (2 * x + 0.1 / x**2))[known], abs=1e-6)
    assert m == pytest.approx(x**2 - 0.1 / x, abs=1e-9)


def test_a_corner_stays_where_a_stored_slope_is_that_of_the_other_side():
    from pddecont.plot.smooth_lines import _choose_slopes

    along, column = np.arange(5.0), np.array([[0.0, 1.0, 2.0, 3.0, 4.0]])
    stored = np.array([[1.0, 1.0, np.nan, 1.0, 5.0]])
    assert _choose_slopes(along, column, stored) == pytest.approx(np.ones((1, 5)))


def test_points_without_tangents_have_no_slopes(every, old):
    for step in (every.step("in_gain"), old.step(next(iter(old.steps)))):
        assert np.isnan(read_slopes(step, "K")).all()
