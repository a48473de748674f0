"""Ten switches make 1024 modes of one compiled field; each oscillator moves as it does alone."""

import numpy as np
import pytest

from pddecont.codegen.machine_code import find_field_cases
from pddecont.errors import ModelError
from tests.conftest import model_from, numeric_from
from tests.simulate.motions import trajectory_of

N = 10


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


def test_each_moves_as_it_does_alone():
    together = numeric_from(oscillators(range(N)))
    assert len(together.model.modes) == 2**N
    assert len(find_field_cases(together.model).fields) == 1
    motion = trajectory_of(together, 40.0)
    times = np.linspace(0.0, 40.0, 201)
    for k in (0, 4, 9):
        alone = trajectory_of(numeric_from(oscillators([k])), 40.0)
        assert motion(times)[:, 2 * k : 2 * k + 2] == pytest.approx(alone(times), abs=1e-7)


def test_more_modes_than_can_be_handled_are_refused():
    with pytest.raises(ModelError, match="make 8192 modes; at most 5000 can be handled"):
        model_from(oscillators(range(13)))
