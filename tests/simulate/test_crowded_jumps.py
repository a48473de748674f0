"""Many lags that vary bring jumps back in every order of the lags: more than can be followed, and all are seen."""

import numpy as np

from pddecont.simulate import Method
from tests.simulate.lagged_models import write_model
from tests.simulate.motions import trajectory_of

LAGS = ("1 + 0.2*tanh(x)", "1.3 - 0.2*tanh(x)", "0.9 + 0.15*x", "1.7 - 0.1*x")
CROWD = write_model(
    ["x"], ["-x/2 - 2.6*tanh({}) + 0.2*{} + 0.15*{} + 0.1*{}".format(*(f"x(t - ({s}))" for s in LAGS))], ["1"]
)


def test_jumps_beyond_number_are_left_to_the_tolerances():
    # Of 4^6 sequences of lags those to order six alone are 4096: here all of them come within eleven units of time.
    trajectory, exact = (
        trajectory_of(CROWD, 30.0, Method(1e-8, 1e-10)),
        trajectory_of(CROWD, 30.0, Method(1e-12, 1e-14)),
    )
    assert trajectory.n_steps < 3000
    times = np.linspace(0.0, 30.0, 301)
    assert np.max(np.abs(trajectory(times) - exact(times))) < 1e-7
