"""Motions are known again whatever their phase, and told from others."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.exploration import (
    Fingerprint,
    Symmetry,
    fingerprint_orbits,
    fingerprint_rest,
    fingerprint_trajectory,
    is_multiple,
)
from pddecont.simulate import Method, simulate
from tests.conftest import numeric_from, shipped
from tests.runs import run

CIRCLE = {"name": "circle", "states": ["x", "v"], "modes": {"free": {"x'": "v", "v'": "4 - x"}}, "initial": {"x": 7}}
BALL = {
    "model": "bouncing_ball",
    "steps": [{"name": "transient", "simulate": {"t_end": 600}}, {"name": "orbit", "orbit": {"from": "transient"}}],
}


@pytest.mark.parametrize("since", [0.0, 1.234, 5.0])
def test_a_circle_has_the_numbers_of_a_circle_wherever_it_begins(since):
    numeric = numeric_from(CIRCLE)
    motion = simulate(numeric, np.zeros(0), Direct(), 20.0, Method(1e-11, 1e-13), initial=[7.0, 0.0], mode="free")
    found = fingerprint_trajectory(motion, 2 * np.pi, since, since + 2 * np.pi)
    # x = 4 + 3 cos t, v = -3 sin t.
    assert found.values[2] == pytest.approx([4, 0], abs=1e-8)
    assert found.values[3] == pytest.approx([3 / np.sqrt(2)] * 2, abs=1e-8)
    assert found.lowest == pytest.approx([1, -3], abs=1e-3)
    assert found.highest == pytest.approx([7, 3], abs=1e-3)


def test_an_orbit_and_the_motion_that_settled_to_it_are_one(tmp_path):
    step = run(BALL, tmp_path / "a.h5").steps["orbit"]
    (orbit,) = fingerprint_orbits(step, np.array([0]))
    numeric = shipped("bouncing_ball")
    p = step.points["parameters"][0]
    motion = simulate(numeric, p, Direct(), 602.3 + 2 * np.pi, Method(1e-11, 1e-13))
    settled = fingerprint_trajectory(motion, 2 * np.pi, 602.3, 602.3 + 2 * np.pi)
    assert settled.values[2:] == pytest.approx(orbit.values[2:], rel=1e-6, abs=1e-8)
    # Extremes are read at a few places of each step and of each interval.
    size = orbit.highest - orbit.lowest
    assert np.max(np.abs(settled.values[:2] - orbit.values[:2]) / size) < 1e-4
    assert orbit.period == pytest.approx(2 * np.pi)


def test_a_mirror_image_has_other_signs():
    rest = fingerprint_rest(np.array([1.0, -2.0]))
    assert rest.apply(Symmetry((0, 1), (-1, -1))).lowest.tolist() == [-1.0, 2.0]
    assert rest.apply(Symmetry((1, 0), (1, -1))).lowest.tolist() == [-2.0, -1.0]
    motion = Fingerprint(3.0, np.array([[-1.0], [4.0], [1.0], [2.0]]))
    mirror = Symmetry((0,), (-1,))
    assert motion.apply(mirror).values[:, 0].tolist() == [-4.0, 1.0, -1.0, 2.0]
    assert motion.apply(mirror).apply(mirror).values.tolist() == motion.values.tolist()


def test_what_is_small_is_measured_by_how_far_motions_go():
    assert fingerprint_rest(np.zeros(2)).measure_size(np.array([1.0, 5.0])).tolist() == [0.01, 0.05]


@pytest.mark.parametrize(
    ("period", "of", "is_one"),
    [(2.0, 1.0, True), (1.0, 2.0, False), (3.0, 1.0, True), (1.5, 1.0, False), (0.0, 0.0, True), (0.0, 1.0, False)],
)
def test_multiples_of_a_period_are_known(period, of, is_one):
    assert is_multiple(period, of) is is_one


def test_a_period_known_roughly_is_compared_roughly():
    assert not is_multiple(2.02, 1.0)
    assert is_multiple(2.02, 1.0, 0.02)
