"""A branch knows which motions lie on it, between its points too."""

import numpy as np
import pytest

from pddecont.exploration import Place, Symmetry, fingerprint_orbits, fingerprint_rest, read_branch
from tests.runs import run

SAME, MIRROR = Symmetry((0,), (1,)), Symmetry((0,), (-1,))
PITCHFORK = {
    "name": "pitchfork",
    "states": ["x"],
    "parameters": {"a": 1},
    "modes": {"free": {"x'": "a*x - x**3"}},
    "run": {
        "steps": [
            {"name": "rest", "equilibrium": {"from": {"x": 0.9}}},
            {
                "name": "branch",
                "continue": {"from": "rest", "free": ["a"], "range": {"a": [0.2, 2]}, "step": {"max": 0.2}},
            },
        ]
    },
}


@pytest.fixture(scope="module")
def pitchfork(tmp_path_factory):
    step = run(PITCHFORK, tmp_path_factory.mktemp("branch") / "a.h5").steps["branch"]
    return read_branch(step, "a", 1.8, np.array([2.0]), (SAME, MIRROR))


@pytest.mark.parametrize("a", [0.2, 0.333, 1.0, 1.7771, 2.0])
def test_what_lies_between_two_points_lies_on_the_branch(pitchfork, a):
    assert pitchfork.find_place(fingerprint_rest(np.array([np.sqrt(a)])), a) == Place("branch", SAME, True)
    assert pitchfork.find_place(fingerprint_rest(np.array([-np.sqrt(a)])), a) == Place("branch", MIRROR, True)


@pytest.mark.parametrize(("x", "a"), [(0.0, 1.0), (1.05, 1.0), (0.9, 1.0), (np.sqrt(2.1), 2.1)])
def test_what_lies_elsewhere_does_not(pitchfork, x, a):
    assert pitchfork.find_place(fingerprint_rest(np.array([x])), a) is None


def test_a_branch_that_is_no_image_of_itself_has_images(pitchfork):
    assert pitchfork.list_images() == [MIRROR]


def test_what_lies_where_a_branch_is_not_stable_is_said_to_do_so(tmp_path):
    # x' = a + x**2 has equilibria at +-sqrt(-a), of which the negative one is stable; they meet at 0.
    model = {"name": "o", "states": ["x"], "parameters": {"a": -1}, "modes": {"free": {"x'": "a + x**2"}}}
    steps = [
        {"name": "rest", "equilibrium": {"from": {"x": -0.9}}},
        {"name": "branch", "continue": {"from": "rest", "free": ["a"], "range": {"a": [-2, 1]}, "step": {"max": 0.1}}},
    ]
    step = run({**model, "run": {"steps": steps}}, tmp_path / "a.h5").steps["branch"]
    branch = read_branch(step, "a", 3.0, np.array([2.0]), (SAME,))
    for a in (-1.9, -0.77, -0.01):
        assert branch.find_place(fingerprint_rest(np.array([-np.sqrt(-a)])), a) == Place("branch", SAME, True)
        assert branch.find_place(fingerprint_rest(np.array([np.sqrt(-a)])), a) == Place("branch", SAME, False)


def test_orbits_of_an_autonomous_branch_are_known_though_their_period_changes(tmp_path):
    steps = [
        {"name": "transient", "simulate": {"t_end": 150}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {"name": "branch", "continue": {"from": "orbit", "free": ["alpha"], "range": {"alpha": [1.7, 2.3]}}},
        {"name": "other", "orbit": {"from": {"step": "branch", "point": "EP2"}}, "set": {"alpha": 2.2}},
    ]
    results = run({"model": "wright", "steps": steps}, tmp_path / "a.h5").steps
    branch = read_branch(results["branch"], "alpha", 0.6, np.array([3.0]), (SAME, MIRROR))
    (motion,) = fingerprint_orbits(results["other"], np.array([0]))
    place = branch.find_place(motion, 2.2)
    assert place is not None
    # Stability was not asked for.
    assert (place.symmetry, place.is_stable) == (SAME, None)
    assert branch.find_place(motion, 2.1) is None
