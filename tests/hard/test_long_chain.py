"""A chain of a thousand stages."""

import numpy as np
import pytest
from scipy.optimize import brentq

from pddecont.errors import ConvergenceError
from tests.problems import IMPACT_SPEED, chain_transfer, grazing_amplitude
from tests.runs import labels, parameter, run


def through_chain(order, *steps):
    """Return a run of the impact oscillator, whose orbits read the delay through a thousand stages."""
    start = {"name": "t", "set": {"K": 0.2}, "delay": {"method": "direct"}, "simulate": {"t_end": "60*2*pi/omega"}}
    return {
        "model": "impact_oscillator",
        "mesh": {"degree": 8, "intervals": 14},
        "monitors": {"top": "max(x)"},
        "delay": {"method": "chain", "order": order, "n": 1000},
        "steps": [start, {"name": "o", "set": {"K": 0.2}, "orbit": {"from": "t"}}, *steps],
    }


@pytest.mark.parametrize("order", [1, 2])
def test_grazing_through_a_thousand_stages(tmp_path, order, record):
    """The free orbit followed down in the gain until it touches the wall: the chain's own closed form says where."""
    down = {"free": ["K"], "range": {"K": [0.17, 0.2]}, "direction": "down", "signature_change": "stop"}
    step = run(through_chain(order, {"name": "c", "continue": {"from": "o", **down}}), tmp_path / "a.h5").step("c")
    D = chain_transfer(0.8, 3.8, order, 1000)
    exact = brentq(lambda K: grazing_amplitude(K, D) - 1.26, 0.17, 0.2, xtol=1e-14)
    assert labels(step) == ["GR1"]
    record(
        f"grazing through 1000 stages of order {order}",
        "closed form of the chain",
        abs(parameter(step, "K", "GR1") - exact),
        1e-10,
    )


def test_a_thousand_stages_of_order_three_are_refused(tmp_path, record):
    """Such a chain magnifies frequencies near its own, rounding errors among them, beyond the size of the orbit: it
    says so.
    """
    with pytest.raises(ConvergenceError, match="The chain magnifies rounding errors to"):
        run(through_chain(3), tmp_path / "a.h5")
    record("1000 stages of order 3", "refused", 0, 0)


def test_an_impacting_orbit_through_a_thousand_stages(tmp_path, record):
    """Each stage of order 2 misses delta^3 of every derivative: a chain twice as long comes four times as near the
    delay equation.
    """
    gaps = []
    for n in (500, 1000):
        mapping = {
            "model": "impact_oscillator",
            "mesh": {"degree": 8, "intervals": 80},
            "monitors": {"v": "at(NC, v)"},
            "delay": {"method": "chain", "order": 2, "n": n},
            "steps": [
                {"name": "t", "delay": {"method": "direct"}, "simulate": {"t_end": "60*2*pi/omega"}},
                {"name": "o", "orbit": {"from": "t"}},
            ],
        }
        step = run(mapping, tmp_path / f"{n}.h5").step("o")
        assert step.points["error_estimate"][0] < 1e-6
        gaps.append(step.points["monitors"][0, 0] - IMPACT_SPEED)
    record("impact speed through 1000 stages, order in their number", "2", abs(np.log2(gaps[0] / gaps[1]) - 2), 0.1)
    record(
        "impact speed, extrapolated from 500 and 1000 stages", "delay equation", abs((4 * gaps[1] - gaps[0]) / 3), 1e-7
    )
