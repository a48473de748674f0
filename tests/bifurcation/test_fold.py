"""Folds of branches, their curves in two parameters and the cusps where two of these meet."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.bifurcation.fold import CUSP, FOLD, define_fold, parameter_tangent
from pddecont.tables import describe_reason
from tests.bifurcation.runs import chain, follow, make_multipliers, settle
from tests.runs import labels, monitor, multipliers, parameter, run

# Harmonic balance with 30 and 45 harmonics, confirmed by shooting: folds of Duffing's response at F = 1.
DUFFING_FOLDS = (1.63530555133761, 2.21316595462876)


# Piecewise linear flows by matrix exponentials.
TWO_IMPACT_FOLD = 26.5224937149  # in beta, K = 0


TWO_IMPACT_FOLD_CHAIN = 0.00383651621681  # in K, beta = 29, N = 15, M = 2


# Harmonic balance: folds at F = .8 and .5, and the cusp where both meet.
DUFFING = {0.8: (1.55979061152864, 2.00841697276337), 0.5: (1.42305610016459, 1.65767045185807)}


CUSP_PLACE = (1.1872998581433, 0.1647022603409)


def test_folds_of_duffings_response(tmp_path):
    text = {
        "model": "duffing",
        "mesh": {"degree": 8, "tol": 1e-09},
        "monitors": {"x_max": "max(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "40*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["omega"],
                    "range": {"omega": [1, 2.5]},
                    "direction": "up",
                    "events_along": {"level": "x_max - 2"},
                },
            },
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    folds = [parameter(step, "omega", name) for name in labels(step) if name.startswith("LP")]
    assert sorted(folds) == pytest.approx(DUFFING_FOLDS, abs=1e-9)
    # No multipliers were asked for, and none computed.
    assert np.all(step.points["stable"] == -1)
    assert len(step.orbits["multipliers"]) == 0
    level = [name for name in labels(step) if name.startswith("UF")]
    assert len(level) == 2
    for name in level:
        assert monitor(step, "x_max", name) == pytest.approx(2, abs=1e-9)
        assert describe_reason(step.reason(step.row(name))) == "level"


def test_the_orbit_with_two_impacts_really_ends_in_a_fold(tmp_path):
    text = {
        "model": "impact_oscillator",
        "set": {"K": 0, "beta": 60},
        "mesh": {"degree": 8, "tol": 1e-10},
        "steps": [
            {"name": "t", "simulate": {"initial": {"x": 0.04, "v": -0.92}, "t_end": "120*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t", "signature": ["NC", "C", "NC", "C"]}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["beta"],
                    "range": {"beta": [20, 70]},
                    "step": {"max": 0.05},
                    "stability": True,
                },
            },
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["LP1"]
    assert parameter(step, "beta", "LP1") == pytest.approx(TWO_IMPACT_FOLD, abs=1e-8)
    assert multipliers(step, step.row("LP1"))[:2] == pytest.approx([1.0, 0.7304026910], abs=1e-6)
    assert np.all(step.points["admissible"] == 1)
    assert sorted(set(step.points["n_unstable"][step.points["kind"] == b""])) == [0, 1]


def test_the_orbit_with_two_impacts_in_the_gain(tmp_path):
    """Fig. 4.2: by brute force it is lost near K = 0.0027; followed, it ends in a fold."""
    steps = [
        *settle("150*2*pi/omega", initial={"x": -0.26, "v": 1.74}),
        follow("c", "o", {"K": [0, 0.3]}, step={"max": 0.02}, direction="up", stability=True),
    ]
    steps[1]["orbit"]["signature"] = ["NC", "C", "NC", "C"]
    step = run(chain(0, steps), tmp_path / "a.h5").step("c")
    assert labels(step) == ["LP1"]
    assert parameter(step, "K", "LP1") == pytest.approx(TWO_IMPACT_FOLD_CHAIN, abs=1e-10)
    assert multipliers(step, step.row("LP1"))[:2] == pytest.approx([1.0, 0.697689695264], abs=1e-5)


def test_folds_of_the_ball(ball):
    step = ball.step("lp")
    G, r = parameter(step, "G"), parameter(step, "r")
    assert math.pi * (1 - r) / (1 + r) == pytest.approx(G, abs=1e-9)
    for i in range(len(step)):
        assert np.min(np.abs(multipliers(step, i) - 1.0)) < 1e-5


def test_folds_of_duffing_and_their_cusp(tmp_path):
    text = {
        "model": "duffing",
        "mesh": {"degree": 9, "tol": 1e-10},
        "steps": [
            {"name": "t", "simulate": {"t_end": "40*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {"from": "o", "free": ["omega"], "range": {"omega": [1, 2.5]}, "direction": "up"},
            },
            {
                "name": "folds",
                "continue": {
                    "from": {"step": "c", "point": "LP1"},
                    "free": ["omega", "F"],
                    "range": {"omega": [1, 2.3], "F": [0.05, 1.1]},
                },
            },
        ],
    }
    text["steps"] += [
        follow(f"to{10 * level:.0f}_{point}", ("c", point), {"F": [level, 1.2], "omega": [0.6, 2.6]}, direction="down")
        for level in DUFFING
        for point in ("LP1", "LP2")
    ]
    results = run(text, tmp_path / "a.h5")
    step = results.step("folds")
    assert labels(step) == ["CP1"]
    assert (parameter(step, "omega", "CP1"), parameter(step, "F", "CP1")) == pytest.approx(CUSP_PLACE, abs=1e-9)
    for level, folds in DUFFING.items():
        ends = [parameter(results.step(f"to{10 * level:.0f}_{point}"), "omega", "EP1") for point in ("LP1", "LP2")]
        assert sorted(ends) == pytest.approx(folds, abs=1e-9)


def evaluation(matrix, scale=None, sparse=False):
    """Return equations whose Jacobian without the free parameter is a matrix."""
    n = len(matrix)
    whole = np.hstack([matrix, np.ones((n, 1))])
    return SimpleNamespace(
        jacobian=lambda: sp.csc_matrix(whole) if sparse else whole,
        orbit=SimpleNamespace(problem=SimpleNamespace(unknowns=SimpleNamespace(free=slice(n, n + 1)))),
        system=SimpleNamespace(scaling=SimpleNamespace(scale=np.ones(n + 1) if scale is None else scale)),
    )


def nearly_singular(n, sigma, seed):
    """Return a matrix with the least singular value sigma and all others 1."""
    rng = np.random.default_rng(seed)
    left, right = (np.linalg.qr(rng.standard_normal((n, n)))[0] for _ in range(2))
    return left @ np.diag([*np.ones(n - 1), sigma]) @ right


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(2, 7), st.floats(-1e-2, 1e-2), st.integers(0, 1000), st.booleans())
def test_the_fold_function_is_the_least_singular_value_of_the_scaled_jacobian(n, sigma, seed, sparse):
    """With b and c the singular vectors u and w, J w = s u gives v = w and g = -s."""
    matrix = nearly_singular(n, sigma, seed)
    at = evaluation(matrix, sparse=sparse)
    function = define_fold(at)
    scaled = matrix / np.max(np.abs(matrix), axis=1)[:, None]
    least = np.linalg.svd(scaled)[1][-1]
    assert abs(function.evaluate(at)) == pytest.approx(least, rel=2e-3, abs=1e-12)
    null, _ = function.find_null(at)
    assert np.linalg.norm(scaled @ null) == pytest.approx(least, rel=2e-2, abs=1e-10)
    assert np.linalg.norm(function.b) == pytest.approx(1.0) and np.linalg.norm(function.c) == pytest.approx(1.0)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(2, 6), st.integers(0, 1000))
def test_it_changes_sign_at_a_fold_and_keeps_its_sign_when_it_is_renewed(n, seed):
    ahead, behind = (evaluation(nearly_singular(n, sigma, seed)) for sigma in (1e-3, -1e-3))
    function = define_fold(ahead)
    assert function.evaluate(ahead) * function.evaluate(behind) < 0.0
    renewed = function.update_at(behind)
    assert np.sign(renewed.evaluate(behind)) == np.sign(function.evaluate(behind))
    assert np.sign(renewed.evaluate(ahead)) == np.sign(function.evaluate(ahead))


@pytest.mark.parametrize("b", [1.0, -1.0])
@pytest.mark.parametrize("c", [1.0, -1.0])
def test_vectors_that_are_renewed_do_not_turn_round(b, c):
    at = evaluation(nearly_singular(4, 1e-3, 7))
    function = define_fold(at)
    turned = replace(function, b=b * function.b, c=c * function.c)
    renewed = turned.update_at(at)
    assert renewed.b @ turned.b == pytest.approx(1.0) and renewed.c @ turned.c == pytest.approx(1.0)
    assert renewed.evaluate(at) == pytest.approx(b * c * function.evaluate(at), rel=1e-9)


def test_along_a_branch_it_is_the_rate_of_the_first_parameter():
    unknowns = SimpleNamespace(free=slice(2, 4))
    at = SimpleNamespace(orbit=SimpleNamespace(problem=SimpleNamespace(unknowns=unknowns)))
    assert parameter_tangent(SimpleNamespace(at=at, tangent=np.array([0.1, 0.2, -0.3, 0.4]))) == -0.3


def test_the_multiplier_of_a_fold_is_taken_out():
    assert np.array_equal(FOLD.remove_critical(make_multipliers([2.0, 1.0 + 1e-9, 0.5])), [2.0, 0.5])


def test_only_curves_of_folds_have_cusps():
    fold = define_fold(evaluation(nearly_singular(3, 1e-3, 0)))
    for defining, number in ((fold, 1), (None, 0)):
        at = SimpleNamespace(system=SimpleNamespace(defining=defining))
        assert len(CUSP.curve_tests(at, None)) == number
