"""Meshes of orbits: pieces between breaking points, whether they still hold, and orbits carried between them."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import MeshRule, equal_cuts
from pddecont.delay import Chain, Direct, find_breaking_points
from pddecont.orbit import Orbit, adapt_mesh, make_mesh, mesh_is_valid, transfer_orbit, transfer_to
from pddecont.orbit.error import estimate_interval_errors
from pddecont.orbit.remesh import find_density, find_pieces, mesh_meets_tolerance
from pddecont.tables import describe_endings
from tests.known_orbits import hard_wall, mackey_glass
from tests.orbit.exact import circle
from tests.runs import monitor, parameter, run

RULE = MeshRule(6, intervals=20)


def test_pieces_lie_between_breaking_points():
    orbit = hard_wall()
    pieces = find_pieces(orbit.problem, orbit.theta, 4).pieces
    points = find_breaking_points(orbit.signature.discontinuity_sources, orbit.theta, 1, 4).by_segment[0]
    ends = np.array([point.coefficients for point in points]) @ orbit.theta
    assert [piece.start @ orbit.theta for piece in pieces] == pytest.approx(ends[:-1])
    assert [piece.end @ orbit.theta for piece in pieces] == pytest.approx(ends[1:])
    # A jump of the state, a delay of 0.7: four echoes matter to a degree of 4.
    assert len(pieces) == 5


@pytest.mark.parametrize("method", [Direct(track=False), Chain(2, 5)])
def test_ways_that_do_not_track_have_one_piece_a_segment(method):
    problem = circle("s", "s", method=method).problem
    assert len(find_pieces(problem, np.array([6.0, 6.0, 1.0]), 5).pieces) == 2


def test_a_mesh_that_did_not_track_is_none_for_a_way_that_does():
    """Its one piece was no mesh with breaking points, in whatever order they are."""
    orbit = hard_wall()
    rough = adapt_mesh(Orbit(replace(orbit.problem, delay=Direct(track=False)), orbit.x), RULE)
    assert len(rough.mesh.pieces) == 1
    tracked = Orbit(replace(rough.problem, delay=orbit.problem.delay), rough.x)
    expected = find_pieces(orbit.problem, orbit.theta, RULE.degree).pieces
    mesh = make_mesh(tracked.problem, tracked.theta, RULE, orbit=tracked)
    assert [piece.start.tolist() for piece in mesh.pieces] == [piece.start.tolist() for piece in expected]


def test_a_mesh_knows_what_it_was_made_for():
    orbit = hard_wall()
    mesh = make_mesh(orbit.problem, orbit.theta, RULE)
    assert (mesh.degree, mesh.n_intervals) == (6, 20)
    assert np.array_equal(mesh.reference_theta, orbit.theta)
    assert mesh.reference_theta is not orbit.theta


def test_a_mesh_holds_until_breaking_points_cross():
    """Of a period of pi, four echoes of 0.7 lie at 0.7, 1.4, 2.1, 2.8; of 0.8 the fourth is past the end, at 0.06."""
    orbit = adapt_mesh(hard_wall(), MeshRule(4, intervals=12))
    # A mesh made for no theta in particular: nothing but the order of its breaking points decides.
    bare = replace(orbit.problem, mesh=replace(orbit.mesh, reference_theta=None))

    def at(tau, problem=orbit.problem):
        p = orbit.parameters.copy()
        p[orbit.numeric.parameter_index("tau")] = tau
        return Orbit(replace(problem, parameters=p), orbit.x)

    assert mesh_is_valid(orbit)
    assert mesh_is_valid(at(0.701))
    for problem in (orbit.problem, bare):
        assert not mesh_is_valid(at(0.8, problem))
        assert not mesh_is_valid(at(0.0, problem))
    # At 0.63 the order is the same; reads have moved too far for the intervals that a mesh was made with.
    assert mesh_is_valid(at(0.63, bare))
    assert not mesh_is_valid(at(0.63))


def test_the_tolerance_is_kept_by_the_worst_interval():
    orbit = adapt_mesh(mackey_glass(), MeshRule(4, intervals=12))
    worst = float(np.max(estimate_interval_errors(orbit)))
    assert mesh_meets_tolerance(orbit, 1.001 * worst)
    assert not mesh_meets_tolerance(orbit, 0.999 * worst)
    assert mesh_meets_tolerance(orbit, None)


def test_an_orbit_on_another_mesh_is_the_same():
    orbit = mackey_glass()
    moved = adapt_mesh(orbit, MeshRule(12, intervals=30))
    assert moved.durations == pytest.approx(orbit.durations)
    # Its reference is itself, so it is in its own phase.
    assert np.array_equal(moved.problem.reference, moved.values)
    back = transfer_orbit(moved, orbit.mesh)
    assert back.values == pytest.approx(orbit.values, abs=1e-9)
    assert back.mesh is orbit.mesh


def test_an_orbit_moves_to_another_problem_with_its_unknowns():
    orbit = circle(level=1.5, free=("tau",))
    mesh = make_mesh(orbit.problem, orbit.theta, RULE)
    moved = transfer_to(orbit, orbit.problem, mesh)
    t = moved.start + mesh.base_times(moved.theta)
    assert moved.values == pytest.approx(np.stack([np.cos(t), np.sin(t)], axis=1), abs=1e-8)
    assert moved.free.tolist() == [1.0]


def test_the_density_cuts_for_its_tolerance():
    """Meshes made from the density of a solution's own errors."""
    orbit = mackey_glass()
    coarse = find_density(orbit, 1e-5)
    fine = find_density(orbit, 1e-8)
    n = [len(density.cut(0.0, orbit.period)) for density in (coarse, fine)]
    assert n[1] > n[0]
    cuts = adapt_mesh(orbit, MeshRule(10, tol=1e-8)).mesh.pieces[0].cuts
    assert cuts == pytest.approx(fine.cut(0.0, orbit.period))
    assert len(cuts) != len(equal_cuts([3])[0])


@pytest.mark.parametrize(("degree", "tol"), [(3, 1e-5), (6, 1e-8), (9, 1e-11)])
def test_multiples_of_a_delay_that_meet_whole_periods_are_passed(tmp_path, degree, tol):
    """y' = 1 - y + k x(t - tau) of a spiking x: y is the same motion for every tau, only later.

    5 tau = 2 T, 4 tau = 2 T, 5 tau = 3 T and tau = T are passed on the way. The mean of x is I - (I - d) / (2 log 2).
    """
    model = {
        "name": "commensurate",
        "states": ["x", "y"],
        "parameters": {"I": 1.5, "tau": 0.3, "d": 0.5, "k": 0.1},
        "modes": {"go": {"x'": "I - x", "y'": "1 - y + k*x(t - tau)"}},
        "events": {"spike": "x - 1"},
        "resets": {"fire": {"x": "d"}},
        "segments": {"rest": {"mode": "go", "event": "spike", "direction": "rising", "reset": "fire", "to": "go"}},
        "initial": {"mode": "go", "x": 0.7},
    }
    branch = {"from": "o", "free": ["tau"], "range": {"tau": [0.26, 0.72]}}
    steps = [
        {"name": "t", "simulate": {"t_end": 30}},
        {"name": "o", "orbit": {"from": "t"}},
        {"name": "b", "continue": branch},
    ]
    block = {"mesh": {"degree": degree, "tol": tol}, "monitors": {"top": "max(y)", "mean": "mean(y)"}, "steps": steps}
    step = run({**model, "run": block}, tmp_path / "a.h5").step("b")
    assert [label for label in step.labels if label] == ["EP1", "EP2"]
    assert all("reached the end of the range" in text for text in describe_endings(step))
    assert np.all(np.diff(parameter(step, "tau")) > 0.0)
    assert monitor(step, "mean") == pytest.approx(np.full(len(step), 1.15 - 0.05 / np.log(2)), abs=max(1e-8, 3 * tol))
    assert np.ptp(monitor(step, "top")) < max(1e-8, 3 * tol)
