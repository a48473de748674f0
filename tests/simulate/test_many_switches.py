"""Twenty switches make a million modes, of which motions build those that they reach."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pddecont.errors import ModelError
from pddecont.model import derived_modes
from tests.conftest import model_from, numeric_from
from tests.simulate.motions import trajectory_of

N = 20


def oscillators(numbers):
    """Return a model of oscillators with soft walls, forced alike, that know nothing of one another."""
    equations = {}
    for k in numbers:
        equations |= {
            f"x{k}'": f"v{k}",
            f"v{k}'": f"cos(t + {k}) - x{k} - 0.1*v{k} - 10*max(0, x{k} - {0.5 + 0.05 * k})",
        }
    states = [name.removesuffix("'") for name in equations]
    return {"name": "walls", "states": states, "forcing": {"period": "2*pi"}, "equations": equations}


def wall_alone(k, times):
    """Return one of these oscillators by another program, which stops at the wall and starts anew beyond it."""
    wall = 0.5 + 0.05 * k
    found, y, t, inside = [], np.zeros(2), 0.0, False

    def meet(_, y):
        return y[0] - wall

    meet.terminal = True
    while t < times[-1]:
        stiffness = 10.0 * inside

        def rates(t, y, stiffness=stiffness):
            return [y[1], np.cos(t + k) - y[0] - 0.1 * y[1] - stiffness * (y[0] - wall)]

        meet.direction = -1 if inside else 1
        now = solve_ivp(
            rates, (t, times[-1]), y, "DOP853", events=meet, rtol=1e-12, atol=1e-13, dense_output=True, max_step=0.3
        )
        found.append((now.t[-1], now.sol))
        t, y, inside = now.t[-1], now.y[:, -1], not inside
    return np.array([next(sol(at) for end, sol in found if at <= end) for at in times])


@pytest.fixture(scope="module")
def together():
    return trajectory_of(numeric_from(oscillators(range(N))), 40.0)


def test_each_of_twenty_moves_as_another_program_says(together):
    times = np.linspace(0.0, 40.0, 201)
    for k in (0, 4, 9, 19):
        assert together(times)[:, 2 * k : 2 * k + 2] == pytest.approx(wall_alone(k, times), abs=1e-8)


def test_only_modes_that_are_reached_are_built(together):
    numeric = numeric_from(oscillators(range(N)))
    model = numeric.model
    assert model.derived.n_modes == 2**N
    assert len(model.modes) == 1
    motion = trajectory_of(numeric, 40.0)
    reached = set(motion.mode)
    assert 30 < len(reached) < 1000
    assert reached <= set(model.modes)
    assert len(model.modes) <= len(reached) + 1
    assert len(numeric.compile().fields.list_addresses("value")) == 1


def test_more_switches_than_can_be_handled_are_refused():
    with pytest.raises(ModelError, match="these equations have 49 switches; at most 48 can be handled"):
        model_from(oscillators(range(49)))


def test_modes_built_at_once_or_as_they_are_reached_give_the_same_numbers(monkeypatch):
    numbers = []
    for few in (32, 0):
        monkeypatch.setattr(derived_modes, "FEW_MODES", few)
        numeric = numeric_from(oscillators(range(4)))
        assert (len(numeric.model.modes) == 16) == (few > 0)
        motion = trajectory_of(numeric, 60.0)
        assert len(set(motion.mode)) > 4
        numbers.append((motion.time, motion.value, motion.coefficients, motion.mode, motion.events))
    (*one, events), (*other, others) = numbers
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a, b)
    assert (events.segment, list(events.t)) == (others.segment, list(others.t))
