"""Columns of several periods: added up, they are those of the periodic orbit."""

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.orbit import Assembly, Rows, adapt_mesh
from pddecont.orbit.jacobian import make_jacobian
from pddecont.orbit.residual import find_elapsed_weights
from pddecont.stability.lagged_columns import LaggedColumns
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass, neuron, with_parameter

ORBITS = {"two segments": impact_oscillator, "hard wall": hard_wall, "no events": mackey_glass, "delayed": neuron}


def fold(wide, columns):
    """Return the sum over the periods, the state after the last reset being that at the next period's start."""
    unknowns, mesh = columns.unknowns, columns.problem.mesh
    total = wide.reshape(len(wide), columns.n_lags, columns.n_columns).sum(axis=1)
    result = total[:, : unknowns.size].copy()
    result[:, unknowns.value_index[mesh.first_base[0]]] += total[:, unknowns.size :]
    return result


@pytest.mark.parametrize("name", ORBITS)
def test_all_periods_together_make_the_jacobian(name):
    """Where every period is alike, the linearised motion is the linearised orbit: row by row, but for its phase."""
    orbit = adapt_mesh(ORBITS[name](), MeshRule(4, intervals=8))
    columns = LaggedColumns(orbit.problem, orbit.equation_reads, {})
    assembly = Assembly(orbit.problem, orbit.equation_reads, columns)
    wide = assembly.pattern.fill(assembly.evaluate(assembly.linearise(orbit, orbit.equation_reads))).toarray()
    jacobian = make_jacobian(orbit).toarray()
    rows = Rows(orbit.problem.unknowns)
    n = rows.period if orbit.signature.has_events else rows.events
    assert fold(wide, columns)[:n] == pytest.approx(jacobian[:n], abs=1e-11 * np.max(np.abs(jacobian)))
    # And something does stand in earlier periods.
    assert np.any(wide[:, columns.n_columns :])


def test_the_time_since_a_delayed_event_by_period():
    orbit = neuron()
    columns = LaggedColumns(orbit.problem, orbit.equation_reads, {})
    (link,) = orbit.problem.links
    assert link.wraps >= 1
    weights = columns.find_elapsed_weights(link).reshape(columns.n_lags, -1)
    assert weights.sum(axis=0) == pytest.approx(find_elapsed_weights(orbit.problem, link))
    # With its own durations in each period: from the end of the source, through whole periods, to the event.
    durations = np.random.default_rng(0).uniform(1, 2, weights.shape)
    exact = np.sum(durations[link.wraps, link.source + 1 :]) + np.sum(durations[1 : link.wraps])
    assert np.sum(weights * durations) == pytest.approx(exact + np.sum(durations[0, : link.segment + 1]))


def test_a_read_of_an_earlier_period_is_one_of_its_columns():
    orbit = hard_wall()
    operators = orbit.equation_reads.operators
    columns = LaggedColumns(orbit.problem, orbit.equation_reads, {})
    weights, points = operators[0].weights, np.arange(orbit.mesh.n_equation_points)
    period, own = np.divmod(columns.read_columns(weights, points, 1), columns.n_columns)
    assert np.array_equal(period, np.broadcast_to(weights.wraps[:, None], period.shape))
    assert np.array_equal(own, orbit.problem.unknowns.value_index[weights.columns, 1])
    assert {0, 1} == set(weights.wraps.tolist())


def test_room_for_all_periods_that_are_read():
    orbit = adapt_mesh(mackey_glass(), MeshRule(4, intervals=8))
    short = LaggedColumns(orbit.problem, orbit.equation_reads, {})
    long = with_parameter(orbit, "tau", 1.2 + 3 * orbit.period, MeshRule(4, intervals=8))
    assert LaggedColumns(long.problem, long.equation_reads, {}).n_lags == short.n_lags + 3


def test_the_state_after_a_segment():
    orbit = impact_oscillator()
    columns = LaggedColumns(orbit.problem, orbit.equation_reads, {})
    unknowns = orbit.problem.unknowns
    assert columns.state_after(0).tolist() == unknowns.value_index[orbit.mesh.first_base[1]].tolist()
    # That after the last is no period's yet.
    assert columns.state_after(1).tolist() == [unknowns.size, unknowns.size + 1]
