"""Edges that move are those at which the slope of the orbit jumps."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.orbit import Orbit, solve_on_mesh
from pddecont.stability.monodromy import linearise_period
from pddecont.stability.moving_edges import find_still_edges
from pddecont.stability.multipliers import multipliers_of_map
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass
from tests.orbits import settle_to_orbit
from tests.stability.long_delays import damped_wall

# An integrate-and-fire neuron that hears itself K times after 1.5 time units.
NEURON = {
    "name": "neuron",
    "states": ["x"],
    "parameters": {"a": 1.5, "K": 0, "tau": 1.5},
    "modes": {"m": {"x'": "a - x + K*x(t - tau)"}},
    "events": {"fire": "x - 1"},
    "resets": {"zero": {"x": 0}},
    "segments": {"s": {"mode": "m", "event": "fire", "direction": "rising", "reset": "zero", "to": "m"}},
}


def firing_neuron():
    return settle_to_orbit(NEURON, mesh={"degree": 6, "intervals": 6})


def returned_edges(orbit):
    """Return the edges that lie some delays after an event, with the number of delays."""
    S = orbit.mesh.n_segments
    edges = [piece.start for piece in orbit.mesh.pieces]
    return {tuple(edge.tolist()): round(float(np.sum(edge[S:]))) for edge in edges if np.any(edge[S:])}


def test_where_a_jump_of_the_state_is_read_first_the_edge_moves():
    orbit = hard_wall()
    edges, still = returned_edges(orbit), find_still_edges(orbit)
    assert {1, 2} <= set(edges.values())
    assert {edge for edge, n in edges.items() if n > 1} == still


def test_where_states_do_not_jump_every_returned_edge_stands_still():
    orbit = impact_oscillator()
    edges = returned_edges(orbit)
    assert edges and find_still_edges(orbit) == set(edges)


def test_without_feedback_no_returned_edge_moves_and_no_history_is_left():
    orbit = damped_wall(7.3)
    edges = returned_edges(orbit)
    assert 1 in edges.values() and find_still_edges(orbit) == set(edges)
    assert len(linearise_period(orbit).kept) == 1


def test_a_map_of_an_orbit_whose_edges_stand_still_does_not_serve_one_whose_edges_move():
    """Without feedback nothing jumps; with a little of it the motion is y_k+1 = a map that no mesh may change."""
    orbit = firing_neuron()
    known = linearise_period(orbit).assembly
    for K in (0.002, 0.03):
        p = orbit.parameters.copy()
        p[orbit.numeric.parameter_index("K")] = K
        other = solve_on_mesh(Orbit(replace(orbit.problem, parameters=p), orbit.x)).at.orbit
        assert other.mesh is orbit.mesh and find_still_edges(other) < find_still_edges(orbit)
        shared = linearise_period(other)
        assert shared.assembly is not known
        pieces = tuple(replace(piece) for piece in other.mesh.pieces)
        alone = linearise_period(Orbit(replace(other.problem, mesh=replace(other.mesh, pieces=pieces)), other.x))
        whole = [multipliers_of_map(monodromy, other, 3).values[:3] for monodromy in (alone, shared)]
        assert whole[1] == pytest.approx(whole[0], abs=1e-12)


def test_an_orbit_without_events_has_no_edges():
    assert find_still_edges(mackey_glass()) == frozenset()
