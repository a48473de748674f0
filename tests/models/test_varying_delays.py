"""Expected values of models whose delays vary, calculated a second time without the package's numbers."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, fsolve
from scipy.special import iv

from tests.fourier import find_fourier_orbit
from tests.models.expected import entry, evaluated
from tests.models.fourier_family import begin


def expect(model, what):
    """Return the number or numbers that an entry of a model's file expects, and how far another may be."""
    item = entry(model, what)
    return np.atleast_1d(evaluated(item["value"], {})), 2 * item["tol"]


def compare(found, model, what):
    value, tol = expect(model, what)
    assert np.atleast_1d(found) == pytest.approx(value, abs=tol, rel=0)


def test_state_dependent_lag():
    (period, *extrema), tol = expect("state_dependent_lag", "period and extrema of the orbit at a = 1.5")
    orbit = begin((1.562,), (1.0,), 0.0, 4.1, 0.3).follow((np.linspace(4.15, period, 10), 50))[-1]
    assert orbit.gains[0] == pytest.approx(1.5, abs=tol)
    assert orbit.find_extrema() == pytest.approx(extrema, abs=tol)


def follow_sawtooth(k, eps, h, t_end):
    """Return x and x' of eps x' = -x - k x(t - 1 - x) at multiples of ``h``, from a constant history.

    It is a Runge-Kutta method of order four that reads its past from cubic Hermite polynomials; steps are shorter than
    the lag.
    """
    x, rates = [0.3], [-0.3 * (1 + k) / eps]

    def rate(t, now):
        place = (t - 1 - now) / h
        if place < 0:
            return (-now - k * 0.3) / eps
        i = int(place)
        u, low, high, rise = place - i, h * rates[i], h * rates[i + 1], x[i + 1] - x[i]
        past = x[i] + u * (low + u * (3 * rise - 2 * low - high + u * (low + high - 2 * rise)))
        return (-now - k * past) / eps

    for n in range(round(t_end / h)):
        t, a = n * h, rates[-1]
        b = rate(t + h / 2, x[-1] + h / 2 * a)
        c = rate(t + h / 2, x[-1] + h / 2 * b)
        d = rate(t + h, x[-1] + h * c)
        x.append(x[-1] + h / 6 * (a + 2 * b + 2 * c + d))
        rates.append(rate(t + h, x[-1]))
    return x, rates


def find_cycle(k, eps, h, t_end):
    """Return the period and the extrema of the last cycle."""
    x, rates = follow_sawtooth(k, eps, h, t_end)
    curve = CubicHermiteSpline(h * np.arange(len(x)), x, rates)
    first, end = [t for t in curve.roots(extrapolate=False) if curve(t, 1) > 0][-2:]
    turns = [t for t in curve.derivative().roots(extrapolate=False) if first < t < end]
    return np.array([end - first, max(curve(turns)), min(curve(turns))])


@pytest.mark.parametrize("eps", [0.2, 0.1])
def test_sawtooth(eps):
    coarse, middle, fine = (find_cycle(2.0, eps, h, 60.0) for h in (8e-4, 4e-4, 2e-4))
    assert np.log2(np.abs(coarse - middle) / np.abs(middle - fine)) == pytest.approx(4.0, abs=0.5)
    compare(fine + (fine - middle) / 15, "sawtooth", f"period and extrema at k = 2, eps = {eps}")


def find_gains(w):
    """Return kappa1 and kappa2 with a root i w."""
    lags = w * np.array([1.3, 6.0])
    return np.linalg.solve([np.cos(lags), np.sin(lags)], [-4.75, w])


@pytest.mark.parametrize(
    ("what", "other"), [("two pairs at once", 1.58), ("two pairs at once on the other curve", 1.77)]
)
def test_two_pairs(what, other):
    frequency = expect("two_state_dependent_lags", what)[0][2]
    pair = fsolve(lambda u: find_gains(u[0]) - find_gains(u[1]), [frequency, other], xtol=1e-13)
    assert abs(pair[0] - pair[1]) > 0.1
    compare([*find_gains(pair[0]), pair[0]], "two_state_dependent_lags", what)


@cache
def two_lags():
    return begin((4.56, 2.3), (1.3, 6.0), 4.75, 2.6486, 0.17).follow(([2.66, 2.69, 2.72], 24))


def test_torus_point():
    """The pair's exponent is imaginary at a period that the secant method finds."""
    found, exponent = [], 1j * np.angle(0.0144 + 0.9999j) / 2.72
    orbit = two_lags()[-1]
    for step in range(6):
        if step < 2:
            period = 2.72 + 0.001 * step
        else:
            (a, u), (b, v) = found[-2:]
            period = b - v * (b - a) / (v - u)
        orbit = orbit.at(period, 40)
        exponent = orbit.find_exponent(exponent)
        found.append((period, exponent.real))
        if abs(exponent.real) < 1e-12:
            break
    assert abs(found[-1][1]) < 1e-10
    compare([orbit.gains[0], orbit.period], "two_state_dependent_lags", "torus point")


@pytest.mark.slow
def test_fold():
    """The gain as a function of the period has its maximum there."""
    before = (np.arange(2.66, 2.85, 0.03), 20), (np.arange(2.87, 3.3, 0.03), 60), (np.arange(3.32, 3.7, 0.04), 120)
    near = begin((4.56, 2.3), (1.3, 6.0), 4.75, 2.6486, 0.17).follow(
        *before, ([3.74, 3.76, 3.78, 3.8, 3.82, 3.84], 320)
    )[-4:]
    curve = np.polynomial.Polynomial.fit([o.period for o in near], [o.gains[0] for o in near], 3)
    highest = max(curve(t.real) for t in curve.deriv().roots() if 3.78 < t.real < 3.84)
    compare(highest, "two_state_dependent_lags", "fold")


def find_least(values):
    """Return the least of equally spaced values of a smooth function."""
    i = int(np.argmin(values))
    curve = np.polynomial.Polynomial.fit(np.arange(-2, 3), values[i - 2 : i + 3], 4)
    return min(curve(t.real) for t in curve.deriv().roots() if abs(t.imag) < 1e-9 and abs(t.real) < 2)


def find_touch(equation, gap, guess, period, low, high, n):
    """Return the parameter at which the least of ``gap`` along an orbit is zero, and the orbit."""
    orbit = find_fourier_orbit(equation(0.5 * (low + high)), guess, period, n, free_period=True)

    def least(p):
        nonlocal orbit
        orbit = find_fourier_orbit(equation(p), orbit, orbit.period, n, free_period=True)
        t = np.linspace(0, orbit.period, 2001)
        return find_least(gap(p, t, orbit(t), orbit))

    return brentq(least, low, high, xtol=1e-12), orbit


def settle(step, tau):
    """Return a delay that equals what ``step`` makes of it."""
    for _ in range(60):
        tau = step(tau)
    return tau


def tangential_chip(w, t, x, read):
    tau0, radius = 4.6401058748, 20.0
    tau = settle(lambda tau: tau0 * (1 + (x[0] - read(t - tau)[0]) / (2 * np.pi * radius)), np.full(t.shape, tau0))
    return tau / tau0 + read(t - tau)[2] - x[2]


def test_loss_of_contact():
    zeta, kt, period, size = 0.02, 3.0, 6.16, 0.78

    def equation(w):
        def field(t, x, read):
            force = w * tangential_chip(w, t, x, read)
            return np.array([x[1], kt * force - 2 * zeta * x[1] - x[0], x[3], force - 2 * zeta * x[3] - x[2]])

        return field

    def guess(t):
        phase = 2 * np.pi * t / period
        one = np.array([0.042 + size * np.cos(phase), -size * np.sin(phase)])
        return np.concatenate([kt * one, one])

    w, orbit = find_touch(equation, tangential_chip, guess, period, 0.04187, 0.04189, 10)
    compare([w, orbit.period], "turning_tangential", "where the tool loses contact")


def find_cut(om, t, x, read):
    tau = settle(lambda tau: (2 * np.pi - x[2] + read(t - tau)[2]) / om, np.full(t.shape, 2 * np.pi / om))
    return 0.3 * tau + x[0] - read(t - tau)[0]


def test_bit_bounce():
    wz, cz, ct, psi, creep, period = 1.6, 0.1, 0.1, 0.8, 0.1, 3.123

    def law(cut, speed):
        return (cut + 0.4 * np.exp(-1.5 * speed)) * np.tanh(speed / creep)

    def equation(om):
        steady = 2 * np.pi * 0.3 / om

        def field(t, x, read):
            cut = find_cut(om, t, x, read)
            axial = -(wz**2) * x[0] - cz * x[1] - psi * (cut - steady)
            return np.array([x[1], axial, x[3], law(steady, om) - x[2] - ct * x[3] - law(cut, om + x[3])])

        return field

    w = 2j * np.pi / period
    depth = 0.275
    cut = -(wz**2 + w**2 + cz * w) * depth / psi
    twist = -cut / (1 + w**2 + ct * w)

    def guess(t):
        return np.real(np.array([[depth], [w * depth], [twist], [w * twist]]) * np.exp(w * t))

    om, orbit = find_touch(equation, find_cut, guess, period, 3.6955, 3.6975, 12)
    size = 0.5 * np.ptp(orbit(np.linspace(0, orbit.period, 20001))[0])
    compare([om, orbit.period, size], "drill_string", "where the bit begins to bounce")


def hill_matrix(exponent, w, n=40, zeta=0.02, tau0=29.3, depth=0.1, omega=0.2):
    """Return Hill's matrix of x'' + 2 zeta x' + (1 + w) x = w x(t - tau0 (1 + depth cos(omega t))).

    exp(s tau0 depth cos(omega t)) is the sum of I_m(s tau0 depth) exp(i m omega t).
    """
    k = np.arange(-n, n + 1)
    s = exponent + 1j * k * omega
    past = np.exp(-s * tau0) * iv(np.abs(k[:, None] - k), -s * tau0 * depth)
    return (np.diag(s**2 + 2 * zeta * s + 1 + w) - w * past) / (1 + np.abs(s) ** 2)


def test_varying_speed():
    """An exponent i nu is found with the width by Newton's method on a bordered matrix."""
    x = np.array([1.0991, 0.165])
    u, _, vh = np.linalg.svd(hill_matrix(1j * x[0], x[1]))
    left, right = u[:, -1:], vh[-1:]

    def size(x):
        whole = np.block([[hill_matrix(1j * x[0], x[1]), left], [right, np.zeros((1, 1))]])
        value = np.linalg.solve(whole, np.eye(len(whole))[-1])[-1]
        return [value.real, value.imag]

    nu, w = fsolve(size, x, xtol=1e-13)
    assert np.linalg.svd(hill_matrix(1j * nu, w))[1][-1] < 1e-12
    compare(w, "varying_speed", "width at which chatter begins")
