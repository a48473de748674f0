"""A branch knows which motions lie on it, between its points too."""

import numpy as np
import pytest

from pddecont.exploration import fingerprint_orbits, fingerprint_rest, read_branch
from tests.runs import run

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
    return read_branch(step, "a", 1.8, np.array([2.0]))


@pytest.mark.parametrize("a", [0.2, 0.333, 1.0, 1.7771, 2.0])
def test_what_lies_between_two_points_lies_on_the_branch(pitchfork, a):
    assert pitchfork.find_way_of(fingerprint_rest(np.array([np.sqrt(a)])), a) == ""
    assert pitchfork.find_way_of(fingerprint_rest(np.array([-np.sqrt(a)])), a) == "mirrored"


@pytest.mark.parametrize(("x", "a"), [(0.0, 1.0), (1.05, 1.0), (0.9, 1.0), (np.sqrt(2.1), 2.1)])
def test_what_lies_elsewhere_does_not(pitchfork, x, a):
    assert pitchfork.find_way_of(fingerprint_rest(np.array([x])), a) is None


def test_orbits_of_an_autonomous_branch_are_known_though_their_period_changes(tmp_path):
    steps = [
        {"name": "transient", "simulate": {"t_end": 150}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {"name": "branch", "continue": {"from": "orbit", "free": ["alpha"], "range": {"alpha": [1.7, 2.3]}}},
        {"name": "other", "orbit": {"from": {"step": "branch", "point": "EP2"}}, "set": {"alpha": 2.2}},
    ]
    results = run({"model": "wright", "steps": steps}, tmp_path / "a.h5").steps
    branch = read_branch(results["branch"], "alpha", 0.6, np.array([3.0]))
    (motion,) = fingerprint_orbits(results["other"], np.array([0]))
    assert branch.find_way_of(motion, 2.2) == ""
    assert branch.find_way_of(motion, 2.1) is None
