"""The order of time in which the equations of a period's map are solved, against sparse factorisations and steps."""

import numpy as np
import pytest

from pddecont.orbit import order_in_time
from pddecont.stability.monodromy import linearise_period
from tests.known_orbits import chained_impact_oscillator, impact_oscillator, mackey_glass
from tests.orbit.test_time_order import ORBITS, check, solve


@pytest.mark.parametrize("name", ORBITS)
def test_equations_of_a_map(name):
    monodromy = linearise_period(solve(ORBITS[name]).orbit)
    check(monodromy.present.matrix, order_in_time(monodromy.problem, goes_on=True), np.ones(len(monodromy.sizes)))


@pytest.mark.parametrize("make", [impact_oscillator, mackey_glass, chained_impact_oscillator])
def test_the_whole_map_is_that_of_its_steps(make):
    monodromy = linearise_period(solve(make).orbit)
    sizes = monodromy.history_sizes
    steps = np.stack([monodromy.step(column[:, None])[1][:, 0] for column in np.diag(sizes)], axis=1) / sizes[:, None]
    assert monodromy.scaled_matrix == pytest.approx(steps, abs=1e-11 * np.max(np.abs(steps)))
