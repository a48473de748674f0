"""Points of codimension two on curves of folds and Hopf points, of ordinary and delay equations, in closed form."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from mpmath import mp, mpf

from pddecont.tables.words import describe_reason
from tests.equilibrium.harmonic_balance import AMPLITUDE, find_birth
from tests.runs import labels, parameter, run


@dataclass(frozen=True)
class Case:
    """A model with a point of codimension two at ``place``, found on curves that begin at points ``starts``.

    The equilibrium near ``rest`` is followed in ``along``, the first free parameter, over its range. ``states`` and
    ``frequencies`` are those of the point, the latter on Hopf curves.
    """

    label: str
    equations: dict[str, str]
    parameters: dict[str, float]
    rest: dict[str, float]
    along: str
    ranges: dict[str, tuple[float, float]]
    starts: tuple[str, ...]
    place: dict[str, float]
    states: dict[str, float]
    frequencies: tuple[float, ...] = ()


# Equilibria of x' = g(x) + ... where g' = g'' = 0.
CUSP = Case(
    "CP",
    {"x": "(a - 0.2) + (b - 0.5)*x - x**3 + y", "y": "-2*y"},
    {"a": -1.0, "b": 1.5},
    {"x": -1.4, "y": 0},
    "a",
    {"a": (-3, 3), "b": (-1, 2)},
    ("LP1",),
    {"a": 0.2, "b": 0.5},
    {"x": 0, "y": 0},
)
# g = a + (b - 1) x + x^2 - x^3: x = 1/3.
CUSP_DELAYED = Case(
    "CP",
    {"x": "-x + a + b*x(t - tau) + x*x(t - tau) - x(t - tau)**3"},
    {"a": -1.0, "b": 1.5, "tau": 0.4},
    {"x": -1.0},
    "a",
    {"a": (-2, 2), "b": (0, 2)},
    ("LP1",),
    {"a": 1 / 27, "b": 2 / 3},
    {"x": 1 / 3},
)
# Folds a = b^2/4 with x = -b/2, Hopf points x = -c.
TAKENS = Case(
    "BT",
    {"x": "y", "y": "a + b*x + c*y + x**2 + x*y"},
    {"a": -0.5, "b": 0.2, "c": 0.5},
    {"x": -0.81, "y": 0},
    "a",
    {"a": (-2, 2), "b": (-2, 3)},
    ("LP1", "HB1"),
    {"a": 0.25, "b": 1.0},
    {"x": -0.5, "y": 0},
    (0.0,),
)
# lambda = A + B exp(-lambda tau) has a double root zero where B = -1/tau = -A: with B = c x - 1, A = b + 2 x + c x.
TAKENS_DELAYED = Case(
    "BT",
    {"x": "a + b*x + x**2 + c*x*x(t - tau) - x(t - tau)"},
    {"a": 1.0, "b": -2.5, "c": 0.5, "tau": 2.0},
    {"x": 0.32},
    "a",
    {"a": (-1, 4), "b": (-5, 1)},
    ("LP1",),
    {"a": 1.5, "b": -2.0},
    {"x": 1.0},
    (0.0,),
)
# y and z turn and grow with b - x, x has its fold at a = 0.
ZERO_HOPF = Case(
    "ZH",
    {
        "x": "a - (x - 1)**2 - y**2 - z**2",
        "y": "(b - x)*y - 2*z - y*(y**2 + z**2)",
        "z": "2*y + (b - x)*z - z*(y**2 + z**2)",
    },
    {"a": 0.5, "b": 1.3},
    {"x": 1.7, "y": 0, "z": 0},
    "a",
    {"a": (-1, 2), "b": (-1, 3)},
    ("LP1", "HB1"),
    {"a": 0.0, "b": 1.0},
    {"x": 1, "y": 0, "z": 0},
    (2.0,),
)
# lambda^2 + c lambda + K = b exp(-lambda tau), K = k + 2 x = b for the root zero; with omega = 2, tau = 2 the pair.
_B = 4 / (1 - math.cos(4))
ZERO_HOPF_DELAYED = Case(
    "ZH",
    {"x": "v", "v": "a - c*v - k*x + b*x(t - tau) - x**2"},
    {"a": 0.0, "b": 2.2, "k": 1.0, "tau": 2.0, "c": -_B * math.sin(4) / 2},
    {"x": 1.2, "v": 0},
    "a",
    {"a": (-2, 2), "b": (1, 4)},
    ("LP1", "HB1"),
    {"a": -((_B - 1) ** 2) / 4, "b": _B},
    {"x": (_B - 1) / 2, "v": 0},
    (2.0,),
)
# Two oscillators of frequencies 1 and w.
DOUBLE_HOPF = Case(
    "HH",
    {
        "x": "(a - 0.1)*x - y - x*(x**2 + y**2) - 1.5*x*(u**2 + v**2)",
        "y": "x + (a - 0.1)*y - y*(x**2 + y**2) - 1.5*y*(u**2 + v**2)",
        "u": "(b + 0.2)*u - w*v - u*(u**2 + v**2) - 0.5*u*(x**2 + y**2)",
        "v": "w*u + (b + 0.2)*v - v*(u**2 + v**2) - 0.5*v*(x**2 + y**2)",
    },
    {"a": -0.3, "b": -0.5, "w": math.sqrt(5)},
    {"x": 0, "y": 0, "u": 0, "v": 0},
    "a",
    {"a": (-1, 1), "b": (-1, 1)},
    ("HB1",),
    {"a": 0.1, "b": -0.2},
    {"x": 0, "y": 0, "u": 0, "v": 0},
    (1.0, math.sqrt(5)),
)
# k - omega^2 = b cos(omega tau), b sin(omega tau) = 0: with tau = pi k - 4 = b and k - 9 = -b.
DOUBLE_HOPF_DELAYED = Case(
    "HH",
    {"x": "v", "v": "-k*x + b*x(t - tau) - x**3"},
    {"b": 1.0, "k": 6.0, "tau": math.pi},
    {"x": 0, "v": 0},
    "b",
    {"b": (1, 4), "k": (5, 8)},
    ("HB1", "HB2"),
    {"b": 2.5, "k": 6.5},
    {"x": 0, "v": 0},
    (2.0, 3.0),
)
# r' = (b1 - 0.1) r + (b2 + 0.3) r^3 - r^5.
BAUTIN = Case(
    "GH",
    {
        "x": "(m - 0.1)*x - y + (n + 0.3)*x*(x**2 + y**2) - x*(x**2 + y**2)**2",
        "y": "x + (m - 0.1)*y + (n + 0.3)*y*(x**2 + y**2) - y*(x**2 + y**2)**2",
    },
    {"m": -0.3, "n": -0.8},
    {"x": 0, "y": 0},
    "m",
    {"m": (-1, 1), "n": (-1, 1)},
    ("HB1",),
    {"m": 0.1, "n": -0.3},
    {"x": 0, "y": 0},
    (1.0,),
)
# Wright's equation with k x^3: Re c1 = (3 k - (3 pi - 2) pi/20) / (1 + pi^2/4) at r tau = pi/2.
BAUTIN_DELAYED = Case(
    "GH",
    {"x": "-r*x(t - tau)*(1 + x) + k*x**3"},
    {"r": 1.2, "k": 0.1, "tau": 1.0},
    {"x": 0},
    "r",
    {"r": (1, 2), "k": (-1, 1)},
    ("HB1",),
    {"r": math.pi / 2, "k": (3 * math.pi - 2) * math.pi / 60},
    {"x": 0},
    (math.pi / 2,),
)
CASES = {name.lower(): value for name, value in list(globals().items()) if isinstance(value, Case) and name.isupper()}


def make_model(case, steps):
    """Return a model with a run that follows its equilibrium, then does more steps."""
    bounds = {case.along: list(case.ranges[case.along])}
    first = [
        {"name": "rest", "equilibrium": {"from": case.rest}},
        {"name": "along", "continue": {"from": "rest", "free": [case.along], "range": bounds}},
    ]
    return {
        "name": "m",
        "states": list(case.equations),
        "parameters": case.parameters,
        "modes": {"m": {f"{name}'": text for name, text in case.equations.items()}},
        "initial": case.rest,
        "run": {"mesh": {"degree": 6, "tol": 1e-9}, "steps": [*first, *steps]},
    }


def follow(case, name, source, point, **more):
    """Return a step that follows a curve in both parameters of a case."""
    ranges = {key: list(bounds) for key, bounds in case.ranges.items()}
    return {
        "name": name,
        "continue": {"from": {"step": source, "point": point}, "free": list(ranges), "range": ranges, **more},
    }


@pytest.mark.parametrize("name", CASES)
def test_the_point_is_where_the_closed_form_says(name, tmp_path):
    """From each curve that it lies on, to rounding; no root is unstable there."""
    case = CASES[name]
    curves = [follow(case, start, "along", start) for start in case.starts]
    results = run(make_model(case, curves), tmp_path / "r.h5")
    for start in case.starts:
        step = results.step(start)
        label = f"{case.label}1"
        assert labels(step)[0] == label
        row = step.row(label)
        for key, value in case.place.items():
            assert parameter(step, key, label) == pytest.approx(value, abs=1e-12)
        assert step.points["states"][row] == pytest.approx(list(case.states.values()), abs=1e-12)
        assert (step.points["n_unstable"][row], step.points["stable"][row]) == (0, 1)
        if start.startswith("HB"):
            assert np.min(np.abs(np.array(case.frequencies) - step.points["frequency"][row])) < 1e-12


def test_a_coefficient_that_is_infinite_is_not_told(tmp_path):
    """At BT on both curves and at ZH on Hopf points another root is zero; at ZH on folds the coefficient is defined."""
    for case in (TAKENS, ZERO_HOPF):
        curves = [follow(case, start, "along", start) for start in case.starts]
        results = run(make_model(case, curves), tmp_path / "r.h5")
        for start in case.starts:
            step = results.step(start)
            told = np.isfinite(step.points["coefficient"])
            row = step.row(f"{case.label}1")
            assert told[row] == ((case.label, start) == ("ZH", "LP1"))
            assert np.all(np.delete(told, row))


def test_at_a_bogdanov_takens_point_folds_and_hopf_points_meet(tmp_path):
    """Folds a = b^2/4, Hopf points a = c (b - c) where b < 2 c; what else there is stands in the note."""
    c = TAKENS.parameters["c"]
    steps = [
        follow(TAKENS, "folds", "along", "LP1"),
        follow(TAKENS, "hopf", "along", "HB1"),
        follow(TAKENS, "hopf_too", "folds", "BT1"),
        follow(TAKENS, "folds_too", "hopf", "BT1"),
    ]
    results = run(make_model(TAKENS, steps), tmp_path / "r.h5")
    for name in ("folds", "folds_too"):
        step = results.step(name)
        a, b = parameter(step, "a"), parameter(step, "b")
        assert a == pytest.approx(b**2 / 4, abs=1e-12) and np.min(b) == -2 and np.max(b) > 2.5
        assert labels(step) == ["BT1"]
        # One root is zero all along; the other, c + x = c - b/2, is the root that passes zero at the point.
        elsewhere = step.points["kind"][step.order] != b"BT"
        assert np.array_equal(step.points["n_unstable"][step.order][elsewhere], (b < 1.0)[elsewhere])
    for name in ("hopf", "hopf_too"):
        step = results.step(name)
        a, b = parameter(step, "a"), parameter(step, "b")
        assert a == pytest.approx(c * (b - c), abs=1e-12) and np.all(b <= 1.0 + 1e-12) and np.min(b) == -2
        assert labels(step) == ["BT1"]
        row = step.row("BT1")
        assert describe_reason(step.reason(row)) == "curves of folds, Hopf points and homoclinic orbits meet here"
        assert step.points["frequency"] == pytest.approx(np.sqrt(1.0 - step.points["parameters"][:, 1]), abs=1e-7)


def test_hopf_points_begin_at_a_bogdanov_takens_point_of_a_delay_equation(tmp_path):
    """lambda = A + B exp(-lambda tau) with lambda = i omega along the whole curve."""
    steps = [follow(TAKENS_DELAYED, "folds", "along", "LP1"), follow(TAKENS_DELAYED, "hopf", "folds", "BT1")]
    step = run(make_model(TAKENS_DELAYED, steps), tmp_path / "r.h5").step("hopf")
    b, x, omega = parameter(step, "b"), step.points["states"][step.order][:, 0], step.points["frequency"][step.order]
    c, tau = TAKENS_DELAYED.parameters["c"], TAKENS_DELAYED.parameters["tau"]
    A, B = b + 2 * x + c * x, c * x - 1
    assert np.abs(1j * omega - A - B * np.exp(-1j * omega * tau)) == pytest.approx(0.0, abs=1e-11)
    assert labels(step)[0] == "BT1" and np.max(omega) > 0.5
    assert parameter(step, "b", "BT1") == pytest.approx(-2.0, abs=1e-12)


def test_at_a_zero_hopf_point_each_curve_leads_to_the_other(tmp_path):
    """Folds a = 0, Hopf points a = (b - 1)^2; l1 = -1 + 1/(2 (b - 1)) up to a factor is zero at b = 1.5."""
    case = ZERO_HOPF
    steps = [
        follow(case, "folds", "along", "LP1"),
        follow(case, "hopf", "along", "HB1"),
        follow(case, "hopf_too", "folds", "ZH1"),
        follow(case, "folds_too", "hopf", "ZH1"),
    ]
    results = run(make_model(case, steps), tmp_path / "r.h5")
    for name in ("folds", "folds_too"):
        step = results.step(name)
        assert np.abs(parameter(step, "a")) == pytest.approx(0.0, abs=1e-12) and labels(step) == ["ZH1"]
        # x'' = -2 y^2/2: a = -1 with the null vector (1, 0, 0).
        assert step.points["coefficient"] == pytest.approx(-1.0, abs=1e-12)
    for name in ("hopf", "hopf_too"):
        step = results.step(name)
        a, b = parameter(step, "a"), parameter(step, "b")
        assert a == pytest.approx((b - 1) ** 2, abs=1e-11)
        assert sorted(labels(step)) == ["GH1", "ZH1"]
        assert parameter(step, "b", "GH1") == pytest.approx(1.5, abs=1e-10)


def test_at_a_zero_hopf_point_of_a_delay_equation_too(tmp_path):
    case = ZERO_HOPF_DELAYED
    steps = [
        follow(case, "folds", "along", "LP1"),
        follow(case, "hopf", "along", "HB1"),
        follow(case, "hopf_too", "folds", "ZH1"),
        follow(case, "folds_too", "hopf", "ZH1"),
    ]
    results = run(make_model(case, steps), tmp_path / "r.h5")
    k, c, tau = (case.parameters[name] for name in ("k", "c", "tau"))
    for name in ("folds", "folds_too"):
        step = results.step(name)
        a, b = parameter(step, "a"), parameter(step, "b")
        assert a == pytest.approx(-((b - k) ** 2) / 4, abs=1e-11) and labels(step) == ["ZH1"]
    for name in ("hopf", "hopf_too"):
        step = results.step(name)
        b, x, w = parameter(step, "b"), step.points["states"][step.order][:, 0], step.points["frequency"][step.order]
        value = -(w**2) + 1j * c * w + k + 2 * x - b * np.exp(-1j * w * tau)
        assert np.abs(value) == pytest.approx(0.0, abs=1e-10) and "ZH1" in labels(step)


def test_at_a_hopf_hopf_point_the_other_pair_and_both_torus_curves_begin(tmp_path):
    """Hopf points a = 0.1 and b = -0.2; with A = a - 0.1, B = b + 0.2 the orbits r1^2 = A lose stability to the other
    pair at B = A/2, the orbits r2^2 = B at A = 1.5 B."""
    case = DOUBLE_HOPF
    steps = [
        follow(case, "hopf", "along", "HB1"),
        follow(case, "other", "hopf", "HH1"),
        follow(case, "again", "other", "HH1"),
        follow(case, "torus", "hopf", "HH1", branch="switch", stability=True),
        follow(case, "other_torus", "other", "HH1", branch="switch"),
    ]
    results = run(make_model(case, steps), tmp_path / "r.h5")
    for name, key, value, frequency in (
        ("hopf", "a", 0.1, 1.0),
        ("other", "b", -0.2, math.sqrt(5)),
        ("again", "a", 0.1, 1.0),
    ):
        step = results.step(name)
        assert parameter(step, key) == pytest.approx(value, abs=1e-13)
        assert step.points["frequency"] == pytest.approx(frequency, abs=1e-13)
        assert labels(step) == ["HH1"]
        assert step.points["n_unstable"][step.row("HH1")] == 0
    for name, slope, period in (("torus", 0.5, 2 * math.pi), ("other_torus", 1 / 1.5, 2 * math.pi / math.sqrt(5))):
        step = results.step(name)
        A, B = parameter(step, "a") - 0.1, parameter(step, "b") + 0.2
        assert slope * A == pytest.approx(B, abs=1e-8) and np.max(A) == pytest.approx(0.9) and np.min(A) < 0.1
        assert step.points["period"] == pytest.approx(period, rel=1e-8)
        assert step.meta["curve"] == "TR"
    assert np.all(results.step("torus").points["n_unstable"] == 0)


def test_at_a_hopf_hopf_point_of_a_delay_equation_the_other_pair(tmp_path):
    """k = 4 + b with omega = 2 and k = 9 - b with omega = 3."""
    case = DOUBLE_HOPF_DELAYED
    steps = [follow(case, "hopf", "along", "HB1"), follow(case, "other", "hopf", "HH1")]
    results = run(make_model(case, steps), tmp_path / "r.h5")
    b, k = (parameter(results.step("hopf"), key) for key in "bk")
    assert k == pytest.approx(4 + b, abs=1e-12)
    b, k = (parameter(results.step("other"), key) for key in "bk")
    assert k == pytest.approx(9 - b, abs=1e-12)


def test_folds_of_orbits_begin_at_a_generalised_hopf_point(tmp_path):
    """r^4 - N r^2 - M = 0 has a double root r^2 = N/2 where N^2 + 4 M = 0, M = m - 0.1 and N = n + 0.3."""
    steps = [follow(BAUTIN, "hopf", "along", "HB1"), follow(BAUTIN, "folds", "hopf", "GH1", branch="switch")]
    step = run(make_model(BAUTIN, steps), tmp_path / "r.h5").step("folds")
    M, N = parameter(step, "m") - 0.1, parameter(step, "n") + 0.3
    assert pytest.approx(-4 * M, abs=1e-8) == N**2 and np.all(N > 0) and np.max(N) > 1.0
    assert step.meta["curve"] == "LP"


@pytest.mark.slow
def test_folds_of_orbits_of_a_delay_equation_begin_as_expansions_of_small_orbits_say(tmp_path):
    """With r = r_0 + p_2(k) A^2 + p_4 A^4 the folds lie at r - r_0 = -p_2^2/(4 p_4), p_2 = p_2' (k - k_0)."""
    case, (r, k) = BAUTIN_DELAYED, BAUTIN_DELAYED.place.values()
    steps = [
        follow(case, "hopf", "along", "HB1"),
        follow(case, "folds", "hopf", "GH1", branch="switch", step={"initial": 0.005, "max": 0.02}),
    ]
    step = run(make_model(case, steps), tmp_path / "r.h5").step("folds")
    exact = (3 * mp.pi - 2) * mp.pi / 60

    def shift(cubic, amplitude):
        """Return (r - r_0) / A^2."""
        birth = find_birth(
            lambda read, p: [-p * read(0, 1) * (1 + read(0, 0)) + cubic * read(0, 0) ** 3], [0], 1.57, 1.57, amplitude
        )
        return 1 / birth.growth

    slope = (shift(exact + mpf("0.001"), AMPLITUDE) - shift(exact - mpf("0.001"), AMPLITUDE)) / 0.002
    quartic = shift(exact, mpf("1e-7")) / 1e-14
    away, up = parameter(step, "r") - r, parameter(step, "k") - k
    near = np.argsort(np.abs(up))[:5]
    assert np.max(np.abs(up[near])) < 0.2
    bend = np.polynomial.polynomial.polyfit(up[near], away[near] / up[near] ** 2, 3)[0]
    assert bend == pytest.approx(-(slope**2) / (4 * quartic), rel=1e-3)
