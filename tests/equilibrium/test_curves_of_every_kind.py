"""Runs that find Hopf points and follow them: every kind of read against closed forms."""

import cmath
import math

import numpy as np
import pytest
from mpmath import mp

from pddecont.equilibrium import Equilibrium, find_birth, solve_equilibrium
from tests.equilibrium import harmonic_balance
from tests.equilibrium.motions import make_motion
from tests.runs import labels, parameter, run


def make_run(parameters, equations, free, ranges, start=None, step=0.1):
    """Return a run that follows the equilibrium next to zero in the first of two parameters, then its Hopf point."""
    one, other = free
    begun = dict.fromkeys(equations, 0.0) if start is None else start
    return {
        "name": "every",
        "states": list(equations),
        "parameters": parameters,
        "modes": {"m": {f"{name}'": text for name, text in equations.items()}},
        "initial": begun,
        "run": {
            "steps": [
                {"name": "rest", "equilibrium": {"from": begun}},
                {
                    "name": "branch",
                    "continue": {
                        "from": "rest", "free": [one], "range": {one: ranges[0]}, "stability": True,
                        "step": {"initial": step, "max": 0.5},
                    },
                },
                {
                    "name": "hopf",
                    "continue": {
                        "from": {"step": "branch", "point": "HB1"}, "free": [one, other],
                        "range": {one: ranges[0], other: ranges[1]},
                    },
                },
            ]
        },
    }  # fmt: skip


def read_curve(results, *names):
    """Return parameters along the Hopf curve, and its frequencies; all its points are of one pair, and counted."""
    step = results.step("hopf")
    assert len(step) > 5
    assert np.all(step.points["counted"] == 1)
    return *(parameter(step, name) for name in names), step.points["frequency"][step.order]


def test_a_lag_that_moves_with_its_state(tmp_path):
    """x' = -a x(t - 1 - c x): a = omega = pi/2 for each c."""
    made = make_run({"a": 1.2, "c": 0.3}, {"x": "-a*x(t - 1 - c*x)"}, ("a", "c"), ([1, 3], [0, 1]))
    results = run(made, tmp_path / "r.h5")
    assert labels(results.step("branch")) == ["HB1"]
    assert parameter(results.step("branch"), "a", "HB1") == pytest.approx(math.pi / 2, abs=1e-12)
    a, c, omega = read_curve(results, "a", "c")
    assert np.allclose(a, math.pi / 2, atol=1e-12) and np.allclose(omega, math.pi / 2, atol=1e-12)
    assert np.ptp(c) == pytest.approx(1.0)


def test_a_lag_that_moves_with_the_equilibrium(tmp_path):
    """x' = 1/2 - a x(t - 1 - c x): x = 1/(2 a), a (1 + c x) = pi/2, so a = pi/2 - c/2 and omega = a."""
    made = make_run({"a": 1.2, "c": 0.3}, {"x": "0.5 - a*x(t - 1 - c*x)"}, ("a", "c"), ([0.8, 3], [0, 1]), {"x": 0.4})
    results = run(made, tmp_path / "r.h5")
    a, c, omega = read_curve(results, "a", "c")
    assert np.allclose(a, math.pi / 2 - c / 2, atol=1e-12) and np.allclose(omega, a, atol=1e-12)


def test_a_lag_by_a_delayed_value(tmp_path):
    """x' = 1/2 - a x(t - 1 - c x(t - b)) has the same Hopf points: nested lags are those at rest."""
    made = make_run(
        {"a": 1.2, "c": 0.3, "b": 0.8}, {"x": "0.5 - a*x(t - 1 - c*x(t - b))"}, ("a", "c"), ([0.8, 3], [0, 1]),
        {"x": 0.4},
    )  # fmt: skip
    a, c, omega = read_curve(run(made, tmp_path / "r.h5"), "a", "c")
    assert np.allclose(a, math.pi / 2 - c / 2, atol=1e-12) and np.allclose(omega, a, atol=1e-12)


def test_a_uniform_kernel(tmp_path):
    """x' = -a int_0^h x(t - s) ds: a = pi^2 / (2 h^2), omega = pi / h."""
    made = make_run({"a": 4.0, "h": 1.0}, {"x": "-a*integral(x(t - s), s, 0, h)"}, ("a", "h"), ([0.5, 9], [0.5, 3]))
    results = run(made, tmp_path / "r.h5")
    assert parameter(results.step("branch"), "a", "HB1") == pytest.approx(math.pi**2 / 2, abs=1e-12)
    a, h, omega = read_curve(results, "a", "h")
    assert np.allclose(a, math.pi**2 / (2 * h**2), atol=1e-11) and np.allclose(omega, math.pi / h, atol=1e-12)


def test_a_uniform_kernel_whose_end_moves(tmp_path):
    """x' = 1/2 - a int_0^(1 + c x) x(t - s) ds: i w = -a (1 - e^(-i w H)) / (i w) - a c x, H = 1 + c x, a x H = 1/2."""
    made = make_run(
        {"a": 4.0, "c": 0.2}, {"x": "0.5 - a*integral(x(t - s), s, 0, 1 + c*x)"}, ("a", "c"), ([1, 9], [-1, 1]),
        {"x": 0.1},
    )  # fmt: skip
    results = run(made, tmp_path / "r.h5")
    a, c, omega = read_curve(results, "a", "c")
    x = results.step("hopf").points["states"][results.step("hopf").order][:, 0]
    assert np.allclose(a * x * (1 + c * x), 0.5, atol=1e-12)
    left = 1j * omega + a * (1 - np.exp(-1j * omega * (1 + c * x))) / (1j * omega) + a * c * x
    assert np.max(np.abs(left)) < 1e-12 * np.max(a)
    assert np.ptp(c) > 1.0


def test_past_rates(tmp_path):
    """x' = a x + b x(t - 1) + c x'(t - 1): i w (1 - c e^(-i w)) = a + b e^(-i w), linear in b and c for each w."""
    made = make_run(
        {"b": -0.5, "c": 0.3, "a": -1.0, "tau": 1.0}, {"x": "a*x + b*x(t - tau) + c*x'(t - tau)"}, ("b", "c"),
        ([-4, 0], [-0.85, 0.85]),
    )  # fmt: skip
    b, c, omega = read_curve(run(made, tmp_path / "r.h5"), "b", "c")
    for beta, gamma, w in zip(b, c, omega, strict=True):
        e = cmath.exp(-1j * w)
        exact = np.linalg.solve([[e.real, (1j * w * e).real], [e.imag, (1j * w * e).imag]], [1.0, w])
        assert [beta, gamma] == pytest.approx(exact, abs=1e-11)
    assert np.ptp(c) > 1.0


def test_a_neutral_hopf_point_in_closed_form(tmp_path):
    """x' + c x'(t - 1) = -a x: w (1 + c e^(-i w)) = i a, so that cos w = -1/c has none, and with -a x(t - 1) instead
    i w (1 + c e^(-i w)) = -a e^(-i w): i w e^(i w) + i w c = -a, so cos w = -c and a = w sin w.
    """
    made = make_run(
        {"a": 0.5, "c": 0.4, "tau": 1.0}, {"x": "-a*x(t - tau) - c*x'(t - tau)"}, ("a", "c"), ([0.1, 4], [-0.85, 0.85])
    )
    results = run(made, tmp_path / "r.h5")
    w = math.acos(-0.4)
    assert parameter(results.step("branch"), "a", "HB1") == pytest.approx(w * math.sin(w), abs=1e-12)
    a, c, omega = read_curve(results, "a", "c")
    assert np.allclose(np.cos(omega), -c, atol=1e-12) and np.allclose(a, omega * np.sin(omega), atol=1e-11)


def test_a_memory_is_the_limit_of_long_integrals():
    """x' = -k int_0^L r^2 s e^(-r s) x(t - s) ds with r L = 45 against L infinite, which is two states more.

    There l (l + r)^2 + k r^2 = 0 has i w with w = r at k = 2 r.
    """
    text = "-k*integral(r**2*s*exp(-r*s)*x(t - s), s, 0, {})"
    ends = {"inf": "inf", "long": "far"}
    model = {"name": "memory", "states": ["x"], "initial": {"x": 0.1}}
    leading = {}
    for name, end in ends.items():
        motion, p = make_motion(
            {**model, "parameters": {"k": 3.4, "r": 1.7, "far": 45 / 1.7}, "modes": {"m": {"x'": text.format(end)}}}
        )
        from pddecont.equilibrium import find_roots

        roots = find_roots(motion.linearise(np.zeros(motion.n_states), p))
        assert roots.counted
        leading[name] = roots.values[np.argmax(roots.values.imag * (roots.values.real > -1e-6))]
        assert leading[name] == pytest.approx(1.7j, abs=1e-13)


HUMPHRIES = {
    "name": "two_lags",
    "states": ["u"],
    "parameters": {"kappa1": 3.0, "kappa2": 2.3, "gamma": 4.75, "eps": 1.0, "a1": 1.3, "a2": 6.0, "c": 1.0},
    "modes": {"m": {"u'": "(-gamma*u - kappa1*u(t - a1 - c*u) - kappa2*u(t - a2 - c*u))/eps"}},
    "initial": {"u": 0},
}


def list_hopf_points(kappa2, low, high):
    """Return kappa1 and omega of all Hopf points in a range: i w + gamma + kappa1 e^(-1.3 i w) + kappa2 e^(-6 i w) = 0.

    From the imaginary part kappa1 = (w - kappa2 sin 6 w) / sin 1.3 w; zeros of the real part are bracketed.
    """

    def find_kappa(w):
        return (w - kappa2 * mp.sin(6 * w)) / mp.sin(1.3 * w)

    def real(w):
        return mp.sin(1.3 * w) * (4.75 + kappa2 * mp.cos(6 * w)) + (w - kappa2 * mp.sin(6 * w)) * mp.cos(1.3 * w)

    grid, found = np.linspace(0.011, 25, 20_000), []
    values = [real(w) for w in grid]
    for left, right, a, b in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
        if a * b < 0:
            w = mp.findroot(real, (left, right), solver="anderson")
            if low < find_kappa(w) < high:
                found.append((float(find_kappa(w)), float(w)))
    return sorted(found)


def test_two_lags_that_move_have_all_hopf_points_along_kappa1(tmp_path):
    """Humphries, DeMasi, Magpantay, Upham 2012: the equation of section 4, whose lags at rest are a1 and a2."""
    made = {
        **HUMPHRIES,
        "run": {
            "steps": [
                {"name": "rest", "equilibrium": {"from": {"u": 0}}},
                {
                    "name": "branch",
                    "continue": {
                        "from": "rest", "free": ["kappa1"], "range": {"kappa1": [0, 14]}, "stability": True,
                        "step": {"initial": 0.05, "max": 0.2},
                    },
                },
            ]
        },
    }  # fmt: skip
    step = run(made, tmp_path / "r.h5").step("branch")
    exact = list_hopf_points(2.3, 0.0, 14.0)
    found = [step.row(label) for label in labels(step) if label.startswith("HB")]
    kappas = [parameter(step, "kappa1")[list(step.order).index(row)] for row in found]
    assert kappas == pytest.approx([kappa for kappa, _ in exact], abs=1e-10)
    assert step.points["frequency"][found] == pytest.approx([w for _, w in exact], abs=1e-10)


def test_the_criticality_of_two_lags_that_move():
    """The first Hopf points for kappa2 = 2.3 and 3, against small orbits in many digits."""
    motion, p = make_motion(HUMPHRIES)
    for kappa2 in (2.3, 3.0):
        for kappa1, omega in list_hopf_points(kappa2, 0.0, 14.0)[:3]:

            def field(read, kappa, kappa2=kappa2):
                u = read(0, 0)
                far = mp.mpf(kappa2) * read(0, 6 + u)
                return [-mp.mpf("4.75") * u - kappa * read(0, mp.mpf("1.3") + u) - far]

            expected = harmonic_balance.find_birth(field, [0.0], omega, kappa1)
            p[:2] = expected.parameter, kappa2
            at, _, _ = solve_equilibrium(Equilibrium(motion, np.zeros(1), p.copy()))
            birth = find_birth(at, 0, 10.0, omega)
            assert birth.frequency == pytest.approx(omega, rel=1e-11)
            assert birth.coefficient == pytest.approx(expected.cubic.real / expected.frequency, rel=1e-9)
            assert birth.growth == pytest.approx(expected.growth, rel=1e-8)
