"""The linear map from history to history: against motions that are known, and as a map."""

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.errors import ConvergenceError
from pddecont.orbit import adapt_mesh, solve_on_mesh
from pddecont.stability.monodromy import linearise_period
from tests.known_orbits import (
    chained_impact_oscillator,
    hard_wall,
    impact_oscillator,
    mackey_glass,
    neuron,
    with_parameter,
)

ORBITS = {
    "two segments": impact_oscillator,
    "hard wall": hard_wall,
    "no events": mackey_glass,
    "delayed events": neuron,
    "chain": chained_impact_oscillator,
}


@pytest.mark.parametrize("name", ORBITS)
def test_it_is_linear_whole_or_step_by_step(name):
    monodromy = linearise_period(solve_on_mesh(adapt_mesh(ORBITS[name](), MeshRule(4, intervals=10))).at.orbit)
    matrix = monodromy.to_matrix()
    assert matrix.shape == (monodromy.size, monodromy.size)
    history = np.random.default_rng(0).normal(size=monodromy.size)
    assert monodromy.apply(history) == pytest.approx(matrix @ history, abs=1e-9 * np.max(np.abs(matrix)))


@pytest.mark.parametrize("name", [*ORBITS, "long delay"])
def test_the_matrix_in_units_of_sizes_is_the_same_map(name):
    if name == "long delay":
        orbit = mackey_glass()
        orbit = with_parameter(orbit, "tau", 1.2 + 2 * orbit.period, MeshRule(6, intervals=12))
    else:
        orbit = ORBITS[name]()
    monodromy = linearise_period(orbit)
    assert name != "long delay" or len(monodromy.kept) > 2
    sizes = monodromy.history_sizes
    scaled = monodromy.to_matrix() * sizes / sizes[:, None]
    assert monodromy.scaled_matrix == pytest.approx(scaled, abs=1e-9 * np.max(np.abs(scaled)))


def test_the_flow_of_an_autonomous_orbit_comes_back_as_it_was():
    """A shift in time is a motion: the orbit's slope, read as a perturbation, is the same a period later."""
    orbit = mackey_glass()
    mesh = orbit.mesh
    local = np.matmul(mesh.basis.differentiate, orbit.values[mesh.base_index])
    slope = np.empty_like(orbit.values)
    slope[mesh.base_index] = local / (mesh.length @ orbit.theta)[:, None, None]
    monodromy = linearise_period(orbit)
    unknowns = orbit.problem.unknowns
    # What a period holds: base values, the duration (none), and the state after its end.
    period = np.concatenate([slope.ravel(), [0.0], slope[-1]])
    assert len(period) == unknowns.size + unknowns.n_states
    history = np.concatenate([period[kept] for kept in monodromy.kept])
    x, after = monodromy.step(history[:, None])
    size = np.max(np.abs(slope))
    assert x[:, 0] == pytest.approx(period, abs=1e-7 * size)
    assert after[:, 0] == pytest.approx(history, abs=1e-7 * size)


def test_a_history_moves_on_by_a_period():
    """With a delay longer by two periods: what was the last period is the one before it, where it is still read."""
    orbit = mackey_glass()
    long = with_parameter(orbit, "tau", 1.2 + 2 * orbit.period, MeshRule(6, intervals=12))
    monodromy = linearise_period(long)
    assert len(monodromy.kept) == len(linearise_period(orbit).kept) + 2
    history = np.random.default_rng(1).normal(size=(monodromy.size, 1))
    x, after = monodromy.step(history)
    ends = np.cumsum([len(kept) for kept in monodromy.kept])[:-1]
    before, after = np.split(history, ends), np.split(after, ends)
    assert np.array_equal(after[0], x[monodromy.kept[0]])
    for w in range(1, len(ends) + 1):
        unknown = dict(zip(monodromy.kept[w - 1].tolist(), before[w - 1][:, 0], strict=True))
        assert after[w][:, 0].tolist() == [unknown[k] for k in monodromy.kept[w].tolist()]


def test_places_of_entries_serve_again():
    """The assembly of one orbit's map is that of another on the same mesh, at other parameters."""
    orbit = impact_oscillator()
    first = linearise_period(orbit)
    again = linearise_period(orbit)
    assert again.assembly is first.assembly
    assert again.to_matrix() == pytest.approx(first.to_matrix(), abs=1e-12)
    other = linearise_period(adapt_mesh(orbit, MeshRule(5, intervals=12)))
    assert other.assembly is not first.assembly


def test_free_parameters_do_not_matter():
    orbit = impact_oscillator()
    fixed = linearise_period(orbit).to_matrix()
    assert linearise_period(orbit.with_free(("K",))).to_matrix() == pytest.approx(fixed, abs=1e-12)


def test_an_orbit_that_reads_its_future_has_no_multipliers():
    bad = with_parameter(mackey_glass(), "tau", -0.3, MeshRule(4, intervals=8))
    with pytest.raises(ConvergenceError, match="a delay is negative here"):
        linearise_period(bad)
