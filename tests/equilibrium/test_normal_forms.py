"""Coefficients of normal forms, against expansions of small orbits in many digits and closed forms."""

import math

import numpy as np
import pytest
from mpmath import mpf

from pddecont.delay import Chain
from pddecont.equilibrium import Equilibrium, find_birth, find_roots
from pddecont.equilibrium.normal_forms import Forms, find_cubic_coefficient, find_fold_coefficient
from tests.equilibrium import harmonic_balance
from tests.equilibrium.hopf_models import ALL, OF_EVERY_KIND
from tests.equilibrium.motions import make_motion

EVERY = ALL | OF_EVERY_KIND


@pytest.fixture(scope="module")
def births():
    """Return Hopf points from equations written in Python alone."""
    return {
        name: harmonic_balance.find_birth(made.field, made.states, made.frequency, made.near)
        for name, made in EVERY.items()
    }


def make_equilibrium(model, parameters, states, method=None):
    """Return an equilibrium of a model at ``parameters``, a mapping, of which others keep their values."""
    motion, p = make_motion(model, method)
    for name, value in parameters.items():
        p[motion.numeric.parameter_index(name)] = value
    return Equilibrium(motion, np.array(states, dtype=float), p)


@pytest.mark.parametrize("name", EVERY)
def test_the_cubic_coefficient_is_that_of_small_orbits(births, name):
    """To rounding: both parts, for up to three delays of every kind, and functions that are no polynomials."""
    made, expected = EVERY[name], births[name]
    at = make_equilibrium(made.model, {made.free: expected.parameter}, expected.states)
    forms = Forms(at)
    critical = forms.find_critical(1j * expected.frequency)
    assert abs(np.vdot(critical.right, expected.vector)) == pytest.approx(1.0, abs=1e-12)
    assert abs(find_cubic_coefficient(forms, critical) - expected.cubic) < 1e-11 * abs(expected.cubic)


@pytest.mark.parametrize("name", EVERY)
def test_orbits_grow_as_small_orbits_do(births, name):
    """The speed of the root is a central difference over 1e-5 of the range."""
    made, expected = EVERY[name], births[name]
    at = make_equilibrium(made.model, {made.free: expected.parameter}, expected.states)
    birth = find_birth(at, at.motion.numeric.parameter_index(made.free), made.range_[1] - made.range_[0])
    assert birth.frequency == pytest.approx(expected.frequency, rel=1e-12)
    assert birth.coefficient == pytest.approx(expected.cubic.real / expected.frequency, rel=1e-10)
    assert birth.growth == pytest.approx(expected.growth, rel=1e-9)


def test_wrights_coefficient_in_closed_form(births):
    closed = -(3 * math.pi - 2) / 10 * (math.pi / 2) / (1 + math.pi**2 / 4)
    assert births["wright"].cubic.real == pytest.approx(closed, rel=1e-14)
    assert births["wright"].growth == pytest.approx(10 / (3 * math.pi - 2), rel=1e-14)


def test_the_coefficient_of_a_fold_of_a_delay_equation():
    """Delta'(0) = 1 + tau, B(1, 1)/2 = a + b."""
    model = {
        "name": "fold",
        "states": ["x"],
        "parameters": {"mu": 0.0, "a": 0.7, "b": 0.4, "tau": 1.5, "two": 2.5},
        "modes": {"m": {"x'": "mu - x + x(t - tau) + a*x(t - tau)**2 + b*x*x(t - two)"}},
        "initial": {"x": 0},
    }
    for a in (0.7, -0.7):
        assert find_fold_coefficient(make_equilibrium(model, {"a": a}, [0.0])) == pytest.approx(
            (a + 0.4) / 2.5, rel=1e-14
        )


def test_the_coefficient_of_a_fold_with_every_kind_of_read():
    """Delta'(0) = 1 + tau - c + k / 2, and B(1, 1)/2 = a + k b: a lag that varies reads the same at rest."""
    model = {
        "name": "fold",
        "states": ["x"],
        "parameters": {"mu": 0.0, "a": 0.7, "b": 0.4, "c": 0.3, "k": 0.6, "tau": 1.5},
        "modes": {
            "m": {
                "x'": "mu - (1 + k)*x + x(t - tau - 2*x) + c*x'(t - 1 + x) + a*x(t - tau)**2"
                " + k*integral(x(t - s) + b*x(t - s)**2, s, 0, 1)"
            }
        },
        "initial": {"x": 0},
    }
    expected = (0.7 + 0.6 * 0.4) / (1 + 1.5 - 0.3 + 0.6 / 2)
    assert find_fold_coefficient(make_equilibrium(model, {}, [0.0])) == pytest.approx(expected, rel=1e-14)


def test_the_coefficient_with_a_moving_lag_in_closed_form():
    """x' = -a x(t - 1 - c x) at a = pi/2: with x = z e^(i w t) + cc + h11 |z|^2 + (h20 z^2 + cc)/2, w = pi/2.

    x(t - 1 - c x) = x_1 - c x x_1' + c^2 x^2 x_1''/2, where x_1 = x(t - 1) and e^(-i w) = -i. Then B(u, v) =
    a c (u v_1' + v u_1') with B(q, q) = 2 a c w and B(q, conj q) = 2 a c w, h11 = 2 c w, h20 = 2 a c w / (2 i w - a).
    """
    a = w = math.pi / 2
    c = 0.3
    model = {
        "name": "moving",
        "states": ["x"],
        "parameters": {"a": a, "c": c},
        "modes": {"m": {"x'": "-a*x(t - 1 - c*x)"}},
        "initial": {"x": 0},
    }
    h11, h20 = 2 * c * w, 2 * a * c * w / (2j * w - a)
    # B(q, h11) = a c h11 q_1', B(conj q, h20) = a c (conj(q) h20_1' + h20 conj(q)_1') with e^(-2 i w) = -1.
    once, twice = a * c * h11 * w, a * c * (-2j * w * h20 + h20 * w)
    # The cubic terms -a c^2 x^2 x_1''/2 give, of q, q, conj q, -a c^2 (2 q conj(q) q_1'' + q q conj(q)_1'').
    cubic = -a * c**2 * (2 * 1j * w**2 - 1j * w**2)
    expected = (cubic + 2 * once + twice) / 2 / (1 + 1j * a)
    at = make_equilibrium(model, {}, [0.0])
    forms = Forms(at)
    assert find_cubic_coefficient(forms, forms.find_critical(1j * w)) == pytest.approx(expected, rel=1e-13)
    assert expected.real / w == pytest.approx(0.0137439515417, rel=1e-10)


@pytest.mark.slow
def test_a_delay_that_a_threshold_defines():
    """int_0^tau (1 + q x(t - s)) ds = 1 and x' = 1/2 - a x(t - tau) (1 + x/5): the delay is a state here.

    Its own root beside those of the equation is -1/tau. The equation written by hand has no such state: |q| is that of
    x alone, and c1 / |q_x|^2 is the same.
    """
    model = {
        "name": "threshold",
        "states": ["x"],
        "parameters": {"a": 1.8, "q": 0.6},
        "delays": {"tau": {"where": "integral(1 + q*x(t - s), s, 0, tau) = 1"}},
        "modes": {"m": {"x'": "0.5 - a*x(t - tau)*(1 + 0.2*x)"}},
        "initial": {"x": 0.3},
    }

    def field(read, a):
        tau, q = mpf(1), mpf(3) / 5
        for _ in range(9):
            over = harmonic_balance.integrate(lambda s: 1 + q * read(0, s), mpf(0), tau) - 1
            tau -= over / (1 + q * read(0, tau))
        return [mpf(1) / 2 - a * read(0, tau) * (1 + read(0, 0) / 5)]

    expected = harmonic_balance.find_birth(field, [0.3], 1.8, 1.8)
    x = expected.states[0]
    tau = 1 / (1 + 0.6 * x)
    at = make_equilibrium(model, {"a": expected.parameter}, [x, tau])
    assert np.max(np.abs(at.motion.rate(at.states, at.parameters))) < 1e-15
    roots = find_roots(at.motion.linearise(at.states, at.parameters))
    assert roots.counted and np.min(np.abs(roots.values + 1 / tau)) < 1e-13
    forms = Forms(at)
    critical = forms.find_critical(1j * expected.frequency)
    cubic = find_cubic_coefficient(forms, critical) / abs(critical.right[0]) ** 2
    assert abs(cubic - expected.cubic) < 1e-12 * abs(expected.cubic)


@pytest.mark.parametrize(("scale", "sign"), [(0.5, 1), (1.0, 1), (2.0, 1), (-0.5, 1), (-1.0, 1), (-2.0, -1)])
def test_the_sign_of_the_coefficient_is_that_of_the_largest_component(scale, sign):
    """x' = mu - x^2 in x with y = scale x: q is (1, scale), turned to a positive component; of two the first."""
    model = {
        "name": "fold",
        "states": ["x", "y"],
        "parameters": {"mu": 0.0, "s": 1.0},
        "modes": {"m": {"x'": "mu - x**2", "y'": "s*x - y"}},
        "initial": {"x": 0},
    }
    # x = y_1 cos, cos = 1/sqrt(1 + s^2) the first component of q: y_1' = -cos y_1^2.
    a = find_fold_coefficient(make_equilibrium(model, {"s": scale}, [0.0, 0.0]))
    assert a == pytest.approx(-sign / math.hypot(1.0, scale), rel=1e-12)


def test_a_chain_has_the_coefficient_of_its_own_ordinary_equations():
    """|q| = 1 counts the states of the chain there: c1 / |q_x|^2 is the same."""
    n, tau = 4, 1.0
    chained = {
        "name": "chained",
        "states": ["x", *(f"z{k}" for k in range(1, n + 1))],
        "parameters": {"r": 1.0},
        "modes": {
            "m": {
                "x'": f"-r*z{n}*(1 + x)",
                "z1'": f"{n / tau}*(x - z1)",
                **{f"z{k}'": f"{n / tau}*(z{k - 1} - z{k})" for k in range(2, n + 1)},
            }
        },
        "initial": {"x": 0.1},
    }
    u = math.pi / (2 * n)
    omega, r = n * math.tan(u) / tau, n * math.tan(u) / tau / math.cos(u) ** n
    values = []
    for at in (
        make_equilibrium(ALL["wright"].model, {"r": r}, [0.0], Chain(1, n)),
        make_equilibrium(chained, {"r": r}, [0.0] * (n + 1)),
    ):
        forms = Forms(at)
        critical = forms.find_critical(1j * omega)
        values.append(find_cubic_coefficient(forms, critical) / abs(critical.right[0]) ** 2)
    assert values[0] == pytest.approx(values[1], rel=1e-12)
