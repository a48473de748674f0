"""Where a branch of orbits dies at an equilibrium."""

import numpy as np
import pytest

from tests.runs import monitor, parameter, run


def test_the_hopf_point_of_mackey_glass(tmp_path):
    """Where the orbit dies its squared amplitude is zero; tau there is that of the characteristic equation (table)."""
    text = {
        "model": "mackey_glass",
        "set": {"n": 10, "tau": 0.6},
        "mesh": {"degree": 9, "tol": 1e-11},
        "monitors": {"amp": "amplitude(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 400}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["tau"],
                    "range": {"tau": [0.4709, 0.6]},
                    "direction": "down",
                    "step": {"max": 0.02},
                },
            },
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    tau, squared = parameter(step, "tau"), monitor(step, "amp") ** 2
    near = squared < 0.002
    assert np.sum(near) > 3
    assert np.polynomial.Polynomial.fit(squared[near], tau[near], 3)(0.0) == pytest.approx(0.4708196289, abs=1e-7)
