"""Orbits as a system of equations: sizes, meshes renewed, and orbits carried between systems."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.collocation import MeshRule
from pddecont.orbit import Orbit, PeriodicOrbitSystem, adapt_mesh, measure_orbit, solve_orbit
from pddecont.orbit.error import estimate_interval_errors
from pddecont.orbit.remesh import find_density
from pddecont.orbit.system import GROWTH_MESHES
from tests.known_orbits import impact_oscillator, mackey_glass
from tests.orbit.exact import TURN, circle

RULE = MeshRule(6, tol=1e-7)


def system_of(orbit, rule=None, ranges=()):
    return PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, ranges), rule)


def test_sizes_and_weights_of_the_unknowns():
    """Values count by their states' sizes, times by the period, parameters by their ranges; all values as all times."""
    orbit = circle("s", "s", level=0.5, free=("level",))
    scaling, unknowns = system_of(orbit, ranges=(3.0,)).scaling, orbit.problem.unknowns
    assert scaling.scale[unknowns.value_index][0] == pytest.approx([1.0, 1.0], rel=0.01)
    assert scaling.scale[unknowns.durations] == pytest.approx([2 * TURN] * 2)
    assert scaling.scale[unknowns.start] == pytest.approx([2 * TURN])
    assert scaling.scale[unknowns.free].tolist() == [3.0]
    assert np.sum(scaling.weight[unknowns.values]) == pytest.approx(1.0)
    assert np.sum(scaling.weight[unknowns.durations]) == pytest.approx(1.0)


def test_an_evaluation_holds_its_orbit():
    orbit = impact_oscillator()
    system = system_of(orbit)
    at = system.at(orbit.x)
    assert at.x is orbit.x
    assert at.residual is at.residual
    assert sp.issparse(at.jacobian())
    # Jacobians of one system have their entries in one place.
    assert system.at(orbit.x * (1.0 + 1e-12)).jacobian().indices is at.jacobian().indices


def test_unknowns_that_no_mesh_changes():
    orbit = impact_oscillator().with_free(("K",))
    system = system_of(orbit, ranges=(1.0,))
    found = orbit.x[system.mesh_independent_index]
    exact = [*orbit.values[orbit.mesh.first_base].ravel(), *orbit.durations, orbit.start, *orbit.free]
    assert found == pytest.approx(exact)


def test_without_a_rule_the_mesh_stays():
    orbit = impact_oscillator()
    system = system_of(orbit)
    far = system.at(orbit.x * 1.5)
    assert system.mesh_is_valid(far)
    assert system.mesh_is_adequate(far)
    assert not system_of(orbit, MeshRule(10, tol=1e-16)).mesh_is_adequate(system.at(orbit.x))


def test_a_new_mesh_carries_all_along():
    orbit = mackey_glass()
    system = system_of(orbit, RULE)
    at, other = system.at(orbit.x), orbit.x * 1.01
    new, x, (same, moved) = system.remesh(at, [at.x, other], solved=True)
    assert new.problem.mesh is not orbit.mesh
    assert new.problem.mesh.degree == 6
    assert same is x
    assert new.density is not None
    t = orbit.mesh.base_times(orbit.theta)
    points, _ = new.problem.mesh.locate(orbit.theta, t[:-1])
    back = Orbit(new.problem, x)
    assert back.mesh.interpolate(back.values, points) == pytest.approx(orbit.values[:-1], abs=1e-5)
    assert moved == pytest.approx(1.01 * x, abs=1e-9)
    # What was found on a mesh is read on the old one.
    again = system.interpolate_from(new, x)
    assert again == pytest.approx(orbit.x, abs=1e-5)
    assert system.interpolate_from(system, orbit.x) is orbit.x


def test_a_guess_is_meshed_as_the_last_solution_wished():
    orbit = mackey_glass()
    system, x, _ = system_of(orbit, RULE).remesh(system_of(orbit).at(orbit.x), [], solved=True)
    wobbly = x * (1 + 0.01 * np.sin(40 * np.arange(len(x))))
    wobbly[system.problem.unknowns.durations] = x[system.problem.unknowns.durations]
    kept, _, _ = system.remesh(system.at(wobbly), [], solved=False)
    assert kept.density is system.density
    assert kept.problem.mesh.n_intervals == system.problem.mesh.n_intervals
    anew, _, _ = system.remesh(system.at(wobbly), [], solved=True)
    assert anew.problem.mesh.n_intervals > system.problem.mesh.n_intervals


def test_an_orbit_becomes_the_reference():
    orbit = mackey_glass()
    system = system_of(orbit, RULE)
    at = system.at(orbit.x * 1.01)
    updated = system.update_reference(at)
    assert np.array_equal(updated.problem.reference, at.orbit.values)
    assert updated.density is not None
    forced = system_of(impact_oscillator())
    assert forced.update_reference(forced.at(impact_oscillator().x)).problem is forced.problem
    assert "read across a jump" in system.explain_unsettled_mesh()


def test_a_mesh_is_kept_while_its_breaking_points_keep_their_order():
    """A delay a little longer moves what is read, not the mesh: unknowns mean the same, and residuals are exact."""
    orbit = adapt_mesh(circle("s", "s", tau=1.1, free=("tau",)), MeshRule(8, intervals=12))
    system = system_of(orbit, MeshRule(8, intervals=12), ranges=(1.0,))
    moved = orbit.x.copy()
    moved[-1] = 1.16
    at = system.at(moved)
    assert not system.mesh_is_valid(at)
    new, x, (other,) = system.remesh(at, [orbit.x], solved=False)
    assert new.problem.mesh.pieces is orbit.mesh.pieces
    assert new.problem.mesh is not orbit.mesh
    assert x is moved
    assert other is orbit.x
    assert new.mesh_is_valid(new.at(x))
    assert new.interpolate_from(system, orbit.x) is orbit.x


def test_a_mesh_that_a_solution_outlives_is_made_anew():
    """By its estimated error, or as many intervals as it asks for."""
    rule = MeshRule(6, tol=1e-7)
    orbit = impact_oscillator()
    for _ in range(3):
        orbit = solve_orbit(adapt_mesh(orbit, rule), rule).at.orbit
    system = system_of(orbit, rule)
    at = system.at(orbit.x)
    kept, outlived = system.update_reference(at, 0.4e-7), system.update_reference(at, 0.6e-7)
    assert not kept.outlived
    assert outlived.outlived
    assert outlived.remesh(at, [], solved=False)[0].problem.mesh.pieces is not orbit.mesh.pieces
    assert system_of(orbit, MeshRule(6, tol=1e-9)).update_reference(at).outlived


def test_where_errors_grow_intervals_are_asked_for_less():
    """An error five times those of the intervals asks for intervals of a third of the tolerance: 0.5 / (0.3 * 5)."""
    rule = MeshRule(6, tol=1e-7)
    orbit = solve_orbit(adapt_mesh(impact_oscillator(), rule), rule).at.orbit
    system, worst = system_of(orbit, rule), float(np.max(estimate_interval_errors(orbit)))
    at = system.at(orbit.x)
    plain, grown = system.update_reference(at, worst), system.update_reference(at, 5.0 * worst)
    assert plain.growth == 1.0 and grown.growth == pytest.approx(5.0)
    assert plain.density.heights == pytest.approx(find_density(orbit, rule.tol).heights)
    assert grown.density.heights == pytest.approx(find_density(orbit, rule.tol / 3.0).heights)
    assert system.update_reference(at, 1e3 * worst).growth == pytest.approx(1e3)
    # Beyond that orbits are not isolated, and no mesh helps.
    assert system.update_reference(at, 1e6 * worst).growth == 1e3
    assert system.update_reference(at, np.inf).growth == 1.0
    # Intervals are not asked for less than rounding leaves.
    exact = system_of(orbit, MeshRule(6, tol=1e-12)).update_reference(at, 1e3 * worst)
    assert exact.growth == 1.0


def test_a_mesh_is_adequate_where_the_error_that_grows_from_it_is():
    rule = MeshRule(6, tol=1e-7)
    orbit = solve_orbit(adapt_mesh(impact_oscillator(), rule), rule).at.orbit
    worst = float(np.max(estimate_interval_errors(orbit)))
    system = system_of(orbit, rule)
    assert system.mesh_is_adequate(system.at(orbit.x))
    grown = replace(system, growth=1.1 * rule.tol / worst)
    assert not grown.mesh_is_adequate(grown.at(orbit.x))
    # What finer meshes do not mend is left as it is.
    assert replace(grown, n_coarse=GROWTH_MESHES).mesh_is_adequate(grown.at(orbit.x))
    finer, x, _ = grown.remesh(grown.at(orbit.x), [], solved=True)
    assert finer.problem.mesh.n_intervals > orbit.mesh.n_intervals and finer.growth == grown.growth
    assert float(np.max(estimate_interval_errors(Orbit(finer.problem, x)))) < worst
