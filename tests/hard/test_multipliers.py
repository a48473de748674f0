"""Defective multipliers, and multipliers clustered at the unit circle."""

import math

import numpy as np
import pytest
from scipy.special import lambertw

from pddecont.collocation import Mesh, equal_cuts
from pddecont.delay import Direct
from pddecont.orbit import Orbit, OrbitProblem, Signature, make_eventless, solve_on_mesh
from pddecont.stability import find_multipliers
from tests.conftest import numeric_from
from tests.orbits import segment_pieces
from tests.runs import multipliers, run


def test_the_delayed_cosine(record):
    """x' = -(pi/2) x(t - 1): orbits of any size, so that +1 is a double multiplier with one vector; its digits are
    worth half.
    """
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {a: 1.5707963267948966}\nmodes: {m: {x': -a*x(t - 1)}}\ninitial: {x: 1}\n"
    )
    mesh = Mesh(10, 1, segment_pieces(1, 2, equal_cuts([16])))
    theta = np.array([4.0, 1.0])
    values = np.cos(math.pi / 2 * mesh.base_times(theta))[:, None]
    signature = Signature(numeric, (make_eventless(numeric.model, "m"),))
    problem = OrbitProblem(signature, mesh, Direct(), numeric.parameter_values, reference=values)
    found = find_multipliers(Orbit(problem, problem.unknowns.join(values, [4.0], 0.0, [])), 6).values
    exact = np.exp(4 * lambertw(-math.pi / 2, k=[1, 2]))
    moduli = np.sort(np.abs(found))[::-1]
    record(
        "delayed cosine, simple multipliers", "exp(4 W_k(-pi/2))", np.max(np.abs(moduli[2:6:2] - np.abs(exact))), 1e-9
    )
    record("delayed cosine, defective double multiplier", "1, half of all digits", np.max(np.abs(found[:2] - 1)), 1e-6)


@pytest.mark.parametrize("size", [2, 3, 4])
def test_jordan_blocks(tmp_path, size, record):
    """A Jordan block in turned coordinates, so that no zero shows it: one eigenvector for all, and 1/size of all
    digits.
    """
    turned, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((size, size)))
    matrix = turned @ (np.diag(np.full(size, -0.2)) + np.diag(np.ones(size - 1), 1)) @ turned.T
    names = [f"x{i}" for i in range(size)]
    rates = {
        f"{n}'": "cos(2*pi*t) + " + " + ".join(f"({a!r})*{other}" for a, other in zip(row, names, strict=True))
        for n, row in zip(names, matrix.tolist(), strict=True)
    }
    steps = [{"name": "t", "simulate": {"t_end": 300}}, {"name": "o", "orbit": {"from": "t", "stability": True}}]
    model = {
        "name": "jordan",
        "states": names,
        "parameters": {"w": 1},
        "forcing": {"period": 1},
        "modes": {"m": rates},
        "run": {"mesh": {"degree": 8, "intervals": 6}, "steps": steps},
    }
    found = multipliers(run(model, tmp_path / "a.h5").step("o"))
    assert len(found) == size
    apart = np.max(np.abs(found - math.exp(-0.2)))
    record(
        f"{size} equal multipliers with one vector",
        f"exp(-0.2), 1/{size} of all digits",
        apart,
        10 * 1e-15 ** (1 / size),
    )
    record(f"their mean ({size})", "exp(-0.2)", abs(np.mean(found) - math.exp(-0.2)), 1e-12)


def test_twelve_multipliers_within_a_thousandth_of_the_unit_circle(tmp_path, record):
    """Six oscillators side by side, hardly damped and in part hardly driven apart, some growing: all told apart, and on
    the right side.
    """
    frequencies, damping = [1.0, 1.0001, 1.3, 1.7, 2.1, 2.9], [1e-5, 1e-5, -1e-5, 5e-5, 1e-4, -1e-4]
    names = [n for i in range(6) for n in (f"x{i}", f"v{i}")]
    rates = ", ".join(
        f"x{i}': v{i}, v{i}': cos(t*2*pi/T) - {c!r}*v{i} - {w * w!r}*x{i}"
        for i, (w, c) in enumerate(zip(frequencies, damping, strict=True))
    )
    period = 2.0
    numeric = numeric_from(
        f"name: choir\nstates: [{', '.join(names)}]\nparameters: {{T: {period}}}\nforcing: {{period: T}}\n"
        f"modes: {{m: {{{rates}}}}}\n"
    )
    mesh = Mesh(9, 1, segment_pieces(1, 1, equal_cuts([8])))
    signature = Signature(numeric, (make_eventless(numeric.model, "m"),))
    problem = OrbitProblem(signature, mesh, Direct(), numeric.parameter_values)
    guess = Orbit(problem, problem.unknowns.join(np.zeros((mesh.n_base, 12)), [period], 0.0, []))
    found = find_multipliers(solve_on_mesh(guess).at.orbit, 12)
    exact = np.array(
        [
            np.exp(period * (-c / 2 + s * 1j * math.sqrt(w * w - c * c / 4)))
            for w, c in zip(frequencies, damping, strict=True)
            for s in (1, -1)
        ]
    )
    assert np.max(np.abs(np.abs(exact) - 1)) < 1e-3
    nearest = np.min(np.abs(found.values[:, None] - exact), axis=0)
    record("12 multipliers within 1e-3 of the unit circle", "closed form", np.max(nearest), 1e-10)
    assert found.n_unstable == 4
