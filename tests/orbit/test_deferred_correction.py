"""The step to a degree more by factors of the orbit's own equations, against that by factors of its own."""

import math

import pytest

from pddecont.collocation import MeshRule
from pddecont.orbit import adapt_mesh, estimate_error, solve_orbit
from pddecont.orbit import deferred_correction as module
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass, neuron
from tests.orbits import settle_to_orbit
from tests.runs import run

COARSE = MeshRule(5, tol=1e-6)


def belt():
    return settle_to_orbit("belt_stick_slip", t_end=60)


@pytest.mark.parametrize("settle", [impact_oscillator, hard_wall, mackey_glass, neuron, belt])
def test_it_is_the_step_that_a_finer_jacobian_gives(settle):
    solution = solve_orbit(adapt_mesh(settle(), COARSE), COARSE)
    whole = estimate_error(solution.at.orbit)
    assert 1e-10 < whole < 1e-3
    assert estimate_error(solution.at.orbit, (), solution.solve) == pytest.approx(whole, rel=0.1)


@pytest.mark.parametrize("factor", [3.0, -1.0])
def test_where_factors_are_of_other_equations_they_are_not_used(factor):
    solution = solve_orbit(adapt_mesh(mackey_glass(), COARSE), COARSE)
    whole = estimate_error(solution.at.orbit)
    assert estimate_error(solution.at.orbit, (), lambda b: factor * solution.solve(b)) == whole


def test_branches_record_it(monkeypatch, tmp_path):
    """Recorded estimates along a branch, where the factors are at hand, against those without."""
    steps = [
        {"name": "t", "simulate": {"t_end": 40 * math.pi}},
        {"name": "o", "orbit": {"from": "t"}},
        {"name": "b", "continue": {"from": "o", "free": ["omega"], "range": {"omega": [1.9, 2.1]}, "max_points": 6}},
    ]
    model = {"model": "wall_oscillator", "mesh": {"degree": 5, "tol": 1e-6}, "steps": steps}
    found = []
    monkeypatch.setattr(
        "pddecont.orbit.estimate.find_deferred_correction",
        lambda *given: found.append(module.find_deferred_correction(*given)) or found[-1],
    )
    estimates = run(model, tmp_path / "a.h5").step("b").points["error_estimate"]
    assert sum(step is not None for step in found) >= 5
    monkeypatch.setattr("pddecont.orbit.estimate.find_deferred_correction", lambda *_: None)
    whole = run(model, tmp_path / "b.h5").step("b").points["error_estimate"]
    assert estimates == pytest.approx(whole, rel=0.05)
