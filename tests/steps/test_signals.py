"""Signals along a trajectory, and that nothing of the past is evaluated where none asks for it."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import simulate
from pddecont.steps.execution.signals import evaluate_signals
from tests.conftest import numeric_from
from tests.simulate.lagged_models import decay

TIMES = np.linspace(0.0, 2.0, 9)
LAGS = {"1": lambda x: 1.0, "1 + x/4": lambda x: 1.0 + x / 4}


def late_decay(lag):
    """Return a model whose motion is exp(-t), with a value read ``lag`` ago in its equation."""
    return numeric_from(decay(f"-x(t - ({lag}))*exp(-({lag}))"))


@pytest.mark.parametrize("lag", LAGS)
def test_a_delayed_value_is_read_where_a_signal_asks_for_it(lag):
    numeric = late_decay(lag)
    p, model = numeric.parameter_values, numeric.model
    # Where the lag varies the rate is read too, for derivatives.
    (late,) = (s for read, s in zip(model.delayed, model.delayed_symbols, strict=True) if read.derivative == 0)
    trajectory = simulate(numeric, p, Direct(), TIMES[-1], keep_from=-np.inf)
    found = evaluate_signals(numeric, [late], trajectory, TIMES, trajectory(TIMES), [(0.0, p)], model.history)
    assert found[:, 0] == pytest.approx(np.exp(LAGS[lag](np.exp(-TIMES)) - TIMES), rel=1e-7)


@pytest.mark.parametrize("lag", LAGS)
def test_nothing_is_read_where_no_signal_asks_for_it(lag):
    """There is no trajectory that could be read."""
    numeric = late_decay(lag)
    states, stages = np.exp(-TIMES)[:, None], [(0.0, numeric.parameter_values)]
    found = evaluate_signals(numeric, [], None, TIMES, states, stages, numeric.model.history)
    assert found.shape == (len(TIMES), 0)
