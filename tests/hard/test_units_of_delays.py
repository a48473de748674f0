"""Delays that vary, rates and integrals of the past in other units of states and time."""

from __future__ import annotations

import numpy as np
import pytest

from pddecont.results import read_results
from tests.runs import multipliers, run

# Every state is divided by its unit and every rate multiplied by that of time; delays are times.
SMOOTH = {
    "states": ["x"],
    "parameters": {"c": 0.3, "n": 0.3, "q": 0.5},
    "modes": {
        "m": {
            "x'": "ux/ut*(-2*tanh(x(t - ut*(1 + c*x/ux))/ux) + n*x'(t - ut/2)*ut/ux"
            " - q*integral(exp(-s/ut)*x(t - s), s, ut/5, ut)/(ux*ut))"
        }
    },
    "initial": {"x": "0.5*ux"},
}
# A wall whose force is read later by a lag that depends on the motion.
WALL = {
    "states": ["x", "v"],
    "parameters": {"c": 0.2, "r": 0.6, "wall": 0.3},
    "forcing": {"period": "ut*2*pi/1.2"},
    "modes": {
        "m": {"x'": "v", "v'": "ux/ut**2*(cos(1.2*t/ut) - 0.4*v*ut/ux - x/ux + 0.2*v(t - ut*(1 + c*x/ux))*ut/ux)"}
    },
    "events": {"hit": "x - ux*wall"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {"s": {"mode": "m", "event": "hit", "direction": "rising", "reset": "bounce", "to": "m"}},
    "initial": {"x": "-0.1*ux", "v": 0.0, "mode": "m"},
}
MODELS = {"smooth": SMOOTH, "wall": WALL}
UNITS = [(1e-6, 1.0), (1e6, 1e-3), (1e-3, 1e6)]


def numbers(name, ux, ut, folder):
    """Return the period and the multipliers of the motion that a model settles to, in units of its own."""
    model = {"name": name, **MODELS[name]}
    model["parameters"] = {**model["parameters"], "ux": ux, "ut": ut}
    speed = ux / ut if name == "wall" else ux
    steps = [
        {"name": "t", "simulate": {"t_end": repr(60 * ut), "atol": 1e-11 * min(ux, speed)}},
        {"name": "o", "orbit": {"from": "t", "stability": True}},
    ]
    # Meshes differ by rounding; what they leave of a multiplier is far less than what is compared.
    run({**model, "run": {"mesh": {"tol": 1e-10}, "steps": steps}}, folder / f"{ux}_{ut}.h5")
    step = read_results(folder / f"{ux}_{ut}.h5").step("o")
    assert step.points["verified"][0] != 0
    return step.points["period"][0] / ut, multipliers(step)


@pytest.fixture(scope="module", params=MODELS)
def plain(request, tmp_path_factory):
    """A model, and its numbers in units of one."""
    return request.param, *numbers(request.param, 1.0, 1.0, tmp_path_factory.mktemp("plain"))


@pytest.mark.parametrize(("ux", "ut"), UNITS)
def test_units_do_not_matter(plain, ux, ut, tmp_path):
    name, period, expected = plain
    found, leading = numbers(name, ux, ut, tmp_path)
    assert found == pytest.approx(period, rel=1e-8)
    large = np.abs(expected) > 1e-3
    assert np.sort_complex(leading[np.abs(leading) > 1e-3]) == pytest.approx(np.sort_complex(expected[large]), abs=1e-7)
