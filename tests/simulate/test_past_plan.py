"""What a simulation knows of the lags of a model."""

import pytest

from pddecont.simulate.past_plan import make_past_plan
from tests.conftest import model_from
from tests.simulate.lagged_models import write_model


@pytest.mark.parametrize(
    "rate, gains",
    [
        ("-x(t - k)", (1,)),
        # d/dt of the integral holds x(t - k): what jumps there jumps two orders higher in x.
        ("-integral(x(t - s), s, 0, k)", (2,)),
        ("-integral(x(t - s), s, 0, k + x/4)", (2,)),
        ("-integral(x(t - s), s, 0, k) - x(t - k)/2", (1,)),
        # The limit itself holds what is read at k.
        ("-integral(x(t - s), s, 0, 2 + x(t - k))", (1, 2)),
    ],
)
def test_by_how_many_orders_jumps_are_smoothed(rate, gains):
    assert make_past_plan(model_from(write_model(["x"], [rate], ["1"]))).gains == gains
