"""A delayed reaction with diffusion, many states: its multipliers are those of the Laplacian's modes, one by one."""

import numpy as np
import pytest

from models.diffusive_logistic import DIFFUSION, diffusive_logistic
from pddecont.model import parse_document
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute

RUN = """run:
  mesh: {degree: 6, tol: TOL}
  steps:
    - {name: transient, simulate: {t_end: 120}}
    - {name: orbit, orbit: {from: transient, stability: true}}
"""
# What all cells do, and a perturbation y in the shape of a mode that the Laplacian multiplies by -L.
MODE = """name: mode
parameters: {r: 1.8, L: RATE}
states: [u, y]
modes:
  growth: {u': r*u*(1 - u(t - 1)), y': (r*(1 - u(t - 1)) - L)*y - r*u*y(t - 1)}
initial: {u: 1.2, y: 0}
"""
ALIKE = """name: alike
parameters: {r: 1.8}
states: [u]
modes:
  growth: {u': r*u*(1 - u(t - 1))}
initial: {u: 1.2}
"""


def find_multipliers(text, tol, path):
    """Return the multipliers of the orbit of a model, by falling modulus."""
    execute(load_run_plan(parse_document(text + RUN.replace("TOL", str(tol)), "m.yaml")), path, overwrite=True)
    return read_results(path).step("orbit").orbit(0)["multipliers"] @ [1, 1j]


def test_multipliers_of_many_cells_are_those_of_their_modes(tmp_path):
    n = 24
    found = find_multipliers(diffusive_logistic(n), 1e-8, tmp_path / "a.h5")
    rates = 4 * DIFFUSION * n**2 * np.sin(np.arange(n) * np.pi / (2 * n)) ** 2
    modes = [
        find_multipliers(MODE.replace("RATE", str(rate)), 1e-10, tmp_path / "m.h5") for rate in rates[1:7].tolist()
    ]
    # Each mode's orbit has the multipliers of what all cells do beside its own.
    alike = find_multipliers(ALIKE, 1e-10, tmp_path / "m.h5")
    own = [values[np.min(np.abs(values[:, None] - alike), axis=1) > 1e-6] for values in modes]
    expected = np.concatenate([alike, *own])
    leading = expected[np.argsort(-np.abs(expected), kind="stable")][:7]
    assert np.sum(np.abs(leading) > 1.0001) == 3
    assert found[:7] == pytest.approx(leading, abs=1e-7)
