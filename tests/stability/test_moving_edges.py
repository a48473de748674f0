"""Edges that move are those at which the slope of the orbit jumps."""

import numpy as np

from pddecont.stability.monodromy import linearise_period
from pddecont.stability.moving_edges import find_still_edges
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass
from tests.stability.long_delays import damped_wall


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


def test_an_orbit_without_events_has_no_edges():
    assert find_still_edges(mackey_glass()) == frozenset()
