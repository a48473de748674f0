"""An orbit as a guess of one with the chain's stages as states."""

import numpy as np
import pytest

from pddecont.codegen import NumericModel
from pddecont.collocation import MeshRule
from pddecont.delay import Chain
from pddecont.model import add_chain_states
from pddecont.orbit import Orbit, OrbitProblem, adapt_mesh, guess_chain_states, parse_monitor, solve_orbit
from tests.known_orbits import mackey_glass
from tests.orbit.exact import circle

RULE = MeshRule(8, intervals=16)


@pytest.mark.parametrize(("order", "n"), [(1, 4), (2, 3), (3, 2)])
def test_stages_begin_as_the_orbit_a_while_ago(order, n):
    """On a circle all of them are known: stage i holds delta^k times derivative k of x and y, i tau / n before."""
    orbit = circle(level=1.5, rule=MeshRule(12, intervals=8))
    numeric = NumericModel(add_chain_states(orbit.numeric.model, order, n))
    guess = guess_chain_states(orbit, numeric, order, n, RULE)
    t = guess.mesh.base_times(guess.theta)
    delta = 1.0 / n
    columns = [np.cos(t), np.sin(t)]
    for read in orbit.numeric.model.delayed:
        for stage in range(1, n + 1):
            for k in range(order):
                phase = t - stage * delta + k * np.pi / 2
                columns.append(delta**k * (np.cos(phase) if read.state == 0 else np.sin(phase)))
    assert guess.values == pytest.approx(np.stack(columns, axis=1), abs=1e-6)
    assert guess.mesh.degree == RULE.degree
    assert guess.durations == pytest.approx(orbit.durations)


def test_the_guess_leads_to_the_orbit_of_the_eliminated_chain():
    """An autonomous orbit: the guess is its own reference of the phase."""
    orbit = mackey_glass()
    numeric = NumericModel(add_chain_states(orbit.numeric.model, 2, 6))
    guess = guess_chain_states(orbit, numeric, 2, 6, RULE)
    assert guess.problem.reference is not None
    written_out = solve_orbit(guess, RULE).at.orbit
    problem = OrbitProblem(orbit.signature, orbit.mesh, Chain(2, 6), orbit.parameters, reference=orbit.values)
    eliminated = solve_orbit(adapt_mesh(Orbit(problem, orbit.x), RULE), RULE).at.orbit
    assert written_out.period == pytest.approx(eliminated.period, abs=1e-7)
    swing = f"amplitude({orbit.numeric.model.states[0]})"
    found = [parse_monitor(o.numeric, "a", swing).evaluate(o) for o in (written_out, eliminated)]
    assert found[0] == pytest.approx(found[1], abs=1e-6)
