"""Folds that turn within 1e-6 of the parameter.

x' = p + d x - x^3 rests where p = x^3 - d x, which turns at x = -+sqrt(d/3), p = +-2 (d/3)^(3/2). A driven variable
that nothing depends on makes an orbit of it.
"""

import numpy as np
import pytest

from tests.runs import labels, parameter, run


def model(d, p, reach):
    """Return the model with its run, a branch through p from -reach to reach."""
    branch = {"from": "o", "free": ["p"], "range": {"p": [-reach, reach]}, "stability": True, "step": {"max": 0.02}}
    return {
        "name": "fold",
        "states": ["x", "y"],
        "parameters": {"p": p, "d": d},
        "forcing": {"period": "2*pi"},
        "modes": {"m": {"x'": "p + d*x - x**3", "y'": "cos(t) - y + x"}},
        "initial": {"x": -0.8},
        "run": {
            "mesh": {"degree": 6, "intervals": 6},
            "monitors": {"x": "mean(x)"},
            "steps": [
                {"name": "t", "simulate": {"t_end": 400}},
                {"name": "o", "orbit": {"from": "t"}},
                {"name": "c", "continue": branch},
            ],
        },
    }


@pytest.mark.parametrize(("window", "reach"), [(1e-4, 0.1), (1e-6, 1.0), (1e-8, 0.01)])
def test_two_folds_in_a_narrow_window(tmp_path, window, reach, record):
    """Both folds lie within ``window`` of the parameter, whose range is twice ``reach``."""
    d = 3 * (window / 4) ** (2 / 3)
    step = run(model(d, -0.5 * reach, reach), tmp_path / "a.h5").step("c")
    assert labels(step) == ["LP1", "LP2"]
    exact = window / 2
    found = np.array([parameter(step, "p", "LP1"), parameter(step, "p", "LP2")])
    record(
        f"two folds within {window:g}, relative to it",
        "closed form",
        np.max(np.abs(found - [exact, -exact])) / window,
        1e-6,
    )
    x, p = step.points["monitors"][:, 0], step.points["parameters"][:, 0]
    record(f"every orbit round folds within {window:g}", "p = x^3 - d x", np.max(np.abs(p - x**3 + d * x)), 1e-12)
