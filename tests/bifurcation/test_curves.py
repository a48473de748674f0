"""Curves of special points in two parameters against closed forms, and their orbits against orbits computed plainly."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.problems import grazing_amplitude
from tests.runs import labels, multipliers, parameter, run, run_model

# Harmonic balance: folds at F = .8 and .5, and the cusp where both meet.
DUFFING = {0.8: (1.55979061152864, 2.00841697276337), 0.5: (1.42305610016459, 1.65767045185807)}
CUSP = (1.1872998581433, 0.1647022603409)
# Spectral collocation with step doubling, apart from this program: n of the doubling at a delay tau.
MACKEY_GLASS_PD = {1.5: 8.77138031192, 2.0: 7.3959269249}  # the second stands in the shared table too


def plain_multipliers(results, name, row, model, path, mesh="degree: 10, tol: 1e-11"):
    """Return the multipliers of a recorded orbit solved anew, its parameters fixed, on a mesh of its own."""
    source = f"{{file: {results.path}, step: {name}, index: {row}}}"
    text = (f"model: {model}\nmesh: {{{mesh}}}\nsteps:\n"
            f"  - {{name: o, orbit: {{from: {source}, stability: {{multipliers: 4}}}}}}\n")  # fmt: skip
    return multipliers(run(text, path / "plain.h5").step("o"))


def check_multipliers(results, name, model, path, tol=1e-8, every=6):
    """Check every sixth orbit of a curve against itself computed plainly."""
    step = results.step(name)
    rows = step.order[::every]
    assert len(rows) > 3
    for i in rows:
        plain, here = plain_multipliers(results, name, int(i), model, path), multipliers(step, i)
        n = min(len(here), 2)
        distance = [np.min(np.abs(plain - v)) for v in here[:n]]
        assert np.max(distance) < tol * max(1.0, np.abs(here[0])), (i, here, plain)


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    text = """\
model: bouncing_ball
mesh: {degree: 9, tol: 1e-11}
steps:
  - {name: t, simulate: {t_end: 200*2*pi}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [G], range: {G: [0.3, 1.2]}, stability: true}}
  - {name: pd, continue: {from: {step: c, point: PD1}, free: [G, r], range: {G: [0.3, 2], r: [0.1, 0.95]}, stability: true}}
  - {name: lp, continue: {from: {step: c, point: LP1}, free: [G, r], range: {G: [0.05, 2], r: [0.1, 0.95]}, stability: true}}
"""
    return run(text, tmp_path_factory.mktemp("ball") / "a.h5")


def test_doublings_of_the_ball(ball, tmp_path):
    step = ball.step("pd")
    assert step.meta["curve"] == "PD"
    G, r = parameter(step, "G"), parameter(step, "r")
    exact = np.sqrt(math.pi**2 * ((1 - r) / (1 + r)) ** 2 + 4 * (1 + r**2) ** 2 / (1 + r) ** 4)
    assert exact == pytest.approx(G, abs=1e-9)
    assert len(step) > 15
    check_multipliers(ball, "pd", "bouncing_ball", tmp_path)


def test_folds_of_the_ball(ball):
    step = ball.step("lp")
    G, r = parameter(step, "G"), parameter(step, "r")
    assert math.pi * (1 - r) / (1 + r) == pytest.approx(G, abs=1e-9)
    for i in range(len(step)):
        assert np.min(np.abs(multipliers(step, i) - 1.0)) < 1e-5


def test_folds_of_duffing_and_their_cusp(tmp_path):
    text = """\
model: duffing
mesh: {degree: 9, tol: 1e-10}
steps:
  - {name: t, simulate: {t_end: 40*2*pi/omega}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [omega], range: {omega: [1, 2.5]}, direction: up}}
  - {name: folds, continue: {from: {step: c, point: LP1}, free: [omega, F], range: {omega: [1, 2.3], F: [0.05, 1.1]}}}
"""
    text += "".join(f"  - {{name: to{int(10 * level)}_{point}, continue: {{from: {{step: c, point: {point}}}, free: [F, omega], range: "
                    f"{{omega: [0.6, 2.6], F: [{level}, 1.2]}}, direction: down}}}}\n"
                    for level in DUFFING for point in ("LP1", "LP2"))  # fmt: skip
    results = run(text, tmp_path / "a.h5")
    step = results.step("folds")
    assert labels(step) == ["CP1"]
    assert (parameter(step, "omega", "CP1"), parameter(step, "F", "CP1")) == pytest.approx(CUSP, abs=1e-9)
    for level, folds in DUFFING.items():
        ends = [parameter(results.step(f"to{int(10 * level)}_{point}"), "omega", "EP1") for point in ("LP1", "LP2")]
        assert sorted(ends) == pytest.approx(folds, abs=1e-9)


def test_doublings_of_mackey_glass(tmp_path):
    text = """\
model: mackey_glass
set: {n: 10, tau: 1.2}
mesh: {degree: 9, tol: 1e-10}
steps:
  - {name: t, simulate: {t_end: 300}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [tau], range: {tau: [1, 1.5]}, stability: true, direction: up}}
  - {name: a, continue: {from: {step: c, point: PD1}, free: [tau, n], range: {tau: [1.3, 1.5], n: [4, 12]}, direction: up}}
  - name: pd
    continue: {from: {step: c, point: PD1}, free: [tau, n], range: {tau: [1.3, 2.0], n: [4, 12]}, direction: up, stability: true}
"""
    results = run(text, tmp_path / "a.h5")
    for name, tau in (("a", 1.5), ("pd", 2.0)):
        step = results.step(name)
        assert parameter(step, "tau", "EP1") == pytest.approx(tau, abs=1e-12)
        assert parameter(step, "n", "EP1") == pytest.approx(MACKEY_GLASS_PD[tau], abs=1e-8)
    check_multipliers(results, "pd", "mackey_glass", tmp_path, every=2)


@pytest.fixture(scope="module")
def torus(tmp_path_factory):
    text = """\
model: pulsed_control
set: {c: 0}
mesh: {degree: 9, tol: 1e-10}
steps:
  - {name: t, set: {c: 1}, simulate: {t_end: 200}}
  - {name: o, set: {c: 1}, orbit: {from: t}}
  - {name: zero, set: {c: 0}, orbit: {from: o}}
  - {name: c, continue: {from: zero, free: [b], range: {b: [-2.2, -0.5]}, stability: true}}
  - {name: tr, continue: {from: {step: c, point: TR1}, free: [b, q], range: {b: [-2.6, -0.5], q: [0.25, 3]}, stability: true}}
"""
    return run(text, tmp_path_factory.mktemp("torus") / "a.h5")


def test_the_torus_curve_and_its_resonances(torus, tmp_path):
    """mu = exp(i w) = b / W(b/q) gives b = -w / sin(w), q = exp(w cot(w)): resonances at w = 2 pi/3, pi/2 and 0 (q = e, b = -1)."""
    step = torus.step("tr")
    b, q = parameter(step, "b"), parameter(step, "q")
    for i, (x, y) in enumerate(zip(b, q, strict=True)):
        if x < -1.001:
            w = brentq(lambda w, x=x: -w / math.sin(w) - x, 1e-9, math.pi - 1e-9, xtol=1e-15)
            assert y == pytest.approx(math.exp(w / math.tan(w)), rel=1e-9), i
    assert set(labels(step)) == {"R3_1", "R4_1", "R1_1"}
    for name, w in (("R3_1", 2 * math.pi / 3), ("R4_1", math.pi / 2)):
        assert parameter(step, "b", name) == pytest.approx(-w / math.sin(w), abs=1e-9)
        assert parameter(step, "q", name) == pytest.approx(math.exp(w / math.tan(w)), abs=1e-9)
    assert (parameter(step, "b", "R1_1"), parameter(step, "q", "R1_1")) == pytest.approx((-1, math.e), abs=1e-6)
    assert any("meets on the real axis" in t for t in step.termination)
    assert not any("WARNING" in t for t in step.termination)
    # Near 1:1 the pair is nearly double, which costs half the digits.
    rows = [i for i in step.order if parameter(step, "b")[list(step.order).index(i)] < -1.05][::6]
    assert len(rows) > 3
    for i in rows:
        plain = plain_multipliers(torus, "tr", int(i), "pulsed_control", tmp_path)
        assert np.sort_complex(multipliers(step, i)[:2]) == pytest.approx(np.sort_complex(plain[:2]), abs=1e-8)


@pytest.fixture(scope="module")
def fig4_8(tmp_path_factory):
    text = """\
model: impact_oscillator
mesh: {degree: 10, tol: 1e-11}
monitors: {x_max: max(x)}
steps:
  - {name: t, simulate: {t_end: 60*2*pi/omega}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [K], range: {K: [0.1, 0.3]}, step: {max: 0.05}, direction: up, stability: true}}
  - {name: gr, continue: {from: {step: c, point: GR1}, free: [tau_d, K], range: {tau_d: [3.0, 4.6], K: [0.05, 0.6]}, stability: true}}
  - {name: one, continue: {from: {step: c, point: VS1}, free: [tau_d, K], range: {tau_d: [2, 7.4], K: [0.05, 0.6]}, stability: true}}
"""
    return run(text, tmp_path_factory.mktemp("fig4_8") / "a.h5")


def test_the_grazing_curve_of_the_free_orbit_is_the_closed_form(fig4_8, tmp_path):
    step = fig4_8.step("one")
    K, tau = parameter(step, "K"), parameter(step, "tau_d")
    assert len(step) > 15
    assert np.max(tau) == 7.4 and np.min(tau) < 2.3
    amplitudes = [grazing_amplitude(k, np.exp(-0.8j * t)) for k, t in zip(K, tau, strict=True)]
    assert amplitudes == pytest.approx([1.26] * len(K), abs=1e-10)
    for k, t in zip(K[:: len(K) // 12], tau[:: len(K) // 12], strict=True):
        exact = brentq(lambda k, t=t: grazing_amplitude(k, np.exp(-0.8j * t)) - 1.26, k - 0.01, k + 0.01, xtol=1e-15)
        assert k == pytest.approx(exact, abs=1e-9)
    check_multipliers(fig4_8, "one", "impact_oscillator", tmp_path, every=8)


def test_the_grazing_curve_of_the_impacting_orbit(fig4_8, tmp_path):
    step = fig4_8.step("gr")
    assert step.meta["curve"] == "GR"
    assert np.all(step.points["admissible"] == 1)
    K, tau = parameter(step, "K"), parameter(step, "tau_d")
    # It passes the grazings that were found in one parameter: K = 0.12 at tau_d = 3.2164416411 lies on it.
    i = int(np.argmin(np.abs(tau - 3.2164)))
    near = np.argsort(np.abs(tau - tau[i]))[:5]
    assert np.polynomial.Polynomial.fit(tau[near], K[near], 4)(3.2164416411) == pytest.approx(0.12, abs=1e-5)
    check_multipliers(fig4_8, "gr", "impact_oscillator", tmp_path, every=9)
    # The side without a third contact lies below the curve here: K smaller.
    inner = [j for j in range(len(step)) if np.isfinite(step.points["side"][j]).all()]
    assert len(inner) == len(step)
    assert np.all(step.points["side"][step.order][(tau > 3.5) & (tau < 3.7), 1] < 0)


def test_hard_impacts_of_speed_zero_in_two_parameters(tmp_path):
    """They lie where the free orbit's amplitude 1 / |1 - w^2 + 0.1 i w| is the wall's distance."""
    text = """\
model: wall_oscillator
mesh: {degree: 9, tol: 1e-11}
steps:
  - {name: t, simulate: {t_end: 300}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [wall], range: {wall: [0.1, 0.5]}, direction: up}}
  - {name: vs, continue: {from: {step: c, point: VS1}, free: [wall, omega], range: {wall: [0.15, 0.8], omega: [1.5, 2.6]}}}
"""
    step = run(text, tmp_path / "a.h5").step("vs")
    wall, omega = parameter(step, "wall"), parameter(step, "omega")
    assert len(step) > 10
    assert 1 / np.hypot(1 - omega**2, 0.1 * omega) == pytest.approx(wall, abs=1e-9)


TWO_WALLS = """\
name: two_walls
states: [x, v]
parameters: {omega: 2.6, a: 0.3, b: 0.35, c: 0.1, r: 0.8}
forcing: {period: 2*pi/omega}
modes: {free: {x': v, v': cos(omega*t) - c*v - x}}
events: {right: x - a, left: x + b}
resets: {bounce: {v: -r*v}}
segments:
  right: {mode: free, event: right, direction: rising, reset: bounce, to: free}
  left: {mode: free, event: left, direction: falling, reset: bounce, to: free}
run:
  mesh: {degree: 9, tol: 1e-11}
  monitors: {top: max(x)}
  steps:
    - {name: t, simulate: {t_end: 200}}
    - {name: o, orbit: {from: t}}
    - name: c
      continue: {from: o, free: [omega], range: {omega: [1.7, 2.7]}, direction: down, signature_change: stop,
                 events_along: {level: top - 0.25}}
    - {name: gr, continue: {from: {step: c, point: GR1}, free: [omega, a], range: {omega: [1.7, 2.7], a: [0.2, 0.5]}}}
    - name: uf
      continue: {from: {step: c, point: UF1}, free: [omega, c], range: {omega: [1.7, 2.7], c: [0.01, 0.5]},
                 events_along: {level: top - 0.25}}
"""


def test_double_grazing_and_a_user_function(tmp_path):
    """The free orbit has amplitude A(w); it touches the right wall where A = a, both where a = b = A; A = 1/4 is the user's own curve."""

    results = run_model(TWO_WALLS, tmp_path / "a.h5")
    step = results.step("gr")
    a, omega = parameter(step, "a"), parameter(step, "omega")
    assert 1 / np.hypot(1 - omega**2, 0.1 * omega) == pytest.approx(a, abs=1e-10)
    assert labels(step) == ["GG1"]
    assert parameter(step, "a", "GG1") == pytest.approx(0.35, abs=1e-10)
    beyond = a > 0.35 + 1e-6
    assert np.any(beyond)
    assert np.all(step.points["admissible"][step.order][beyond] == 0)
    assert np.all(step.points["admissible"][step.order][a < 0.35 - 1e-6] == 1)
    user = results.step("uf")
    assert user.meta["curve"] == "UF"
    omega, c = parameter(user, "omega"), parameter(user, "c")
    assert 1 / np.hypot(1 - omega**2, c * omega) == pytest.approx(0.25, abs=1e-10)
    assert len(user) > 10


HENON = """\
name: henon
states: [x, y]
parameters: {a: 0.3, b: 0.2}
forcing: {period: 1}
modes: {m: {x': 0, y': 0}}
events: {pulse: sin(2*pi*t)}
resets: {g: {x: 1 - a*x**2 + y, y: b*x}}
segments: {s: {mode: m, event: pulse, direction: rising, reset: g, to: m}}
initial: {x: 0.5, y: 0.1}
run:
  mesh: {degree: 3, tol: 1e-9}
  steps:
    - {name: t, simulate: {t_end: 200.5}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [a], range: {a: [-0.3, 1]}, stability: true, max_points: 60}}
    - {name: LP, continue: {from: {step: c, point: LP1}, free: [a, b], range: {a: [-2, 2], b: [-2, 0.3]}, stability: true}}
    - {name: PD, continue: {from: {step: c, point: PD1}, free: [a, b], range: {a: [-1, 4], b: [-2, 0.3]}, stability: true}}
    - {name: turned, continue: {from: {step: c, point: PD1}, free: [b, a], range: {a: [-1, 4], b: [-2, 0.3]}, stability: true}}
    - {name: twice, continue: {from: {step: c, point: PD1}, branch: switch, free: [a], range: {a: [-0.3, 1.2]}, stability: true}}
"""


def test_henons_map_as_a_reset(tmp_path):
    """Folds 4 a = -(1 - b)^2 with multipliers 1, -b; doublings 4 a = 3 (1 - b)^2 with -1, b: 1:1 at (-1, -1), 1:2 at (3, -1), both
    defective. The doubled orbit doubles at 4 a = 4 (1 - b)^2 + (1 + b)^2."""  # fmt: skip

    results = run_model(HENON, tmp_path / "a.h5")
    for name, factor, resonance, at in (("LP", -1, "R1_1", (-1, -1)), ("PD", 3, "R2_1", (3, -1)), ("turned", 3, "R2_1", (3, -1))):
        step = results.step(name)
        a, b = parameter(step, "a"), parameter(step, "b")
        assert factor * (1 - b) ** 2 / 4 == pytest.approx(a, abs=1e-9)
        assert labels(step) == [resonance]
        assert (parameter(step, "a", resonance), parameter(step, "b", resonance)) == pytest.approx(at, abs=1e-9)
    twice = results.step("twice")
    assert parameter(twice, "a", "PD1") == pytest.approx(0.8**2 + 1.2**2 / 4, abs=1e-9)


def test_a_grazing_curve_ends_where_another_contact_vanishes(tmp_path):
    """Between two soft walls the orbit that hits the nearer touches the farther; where both are as far, both are only touched."""
    from tests.bifurcation.test_signatures import SOFT_WALLS

    text = SOFT_WALLS.replace("b: 0.3,", "b: 0.31,").replace("STEP", "{}") + (
        "    - {name: gr, continue: {from: {step: c, point: GR1}, free: [omega, b],\n"
        "                            range: {omega: [1.7, 2.4], b: [0.29, 0.35]}}}\n")  # fmt: skip
    step = run_model(text, tmp_path / "a.h5").step("gr")
    assert labels(step) == ["VS1"]
    assert parameter(step, "b", "VS1") == pytest.approx(0.3, abs=1e-9)
    assert 1 / math.hypot(1 - parameter(step, "omega", "VS1") ** 2, 0.1 * parameter(step, "omega", "VS1")) == pytest.approx(0.3, abs=1e-9)


PRODUCT = """\
name: product
states: [x, y, z]
parameters: {a: 0.3, c: 0.5, d: 0.3}
forcing: {period: 1}
modes: {m: {x': 0, y': 0, z': 0}}
events: {pulse: sin(2*pi*t)}
resets: {g: {x: 1 - a*x**2, y: BLOCK_Y, z: BLOCK_Z}}
segments: {s: {mode: m, event: pulse, direction: rising, reset: g, to: m}}
initial: {x: 0.5}
run:
  mesh: {degree: 3, tol: 1e-9}
  steps:
    - {name: t, simulate: {t_end: 200.5}}
    - {name: o, orbit: {from: t}}
    - {name: n, continue: {from: o, free: [a], range: {a: [-0.3, 1]}, stability: true, max_points: 60}}
    - {name: LP, continue: {from: {step: n, point: LP1}, free: [c, a], range: {a: [-2, 2], c: [-1.3, 1.3]}, stability: true}}
    - {name: PD, continue: {from: {step: n, point: PD1}, free: [c, a], range: {a: [-1, 4], c: [-1.3, 1.3]}, stability: true}}
"""


@pytest.mark.parametrize(("y", "z", "found"), [
    ("c*y", "0.2*z", {"LP": {"R1_1": 1, "FF1": -1}, "PD": {"FF1": 1, "R2_1": -1}}),
    ("c*(0.6*y - 0.8*z)", "c*(0.8*y + 0.6*z)", {"LP": {"FT1": -1, "FT2": 1}, "PD": {"PT1": -1, "PT2": 1}}),
])  # fmt: skip
def test_points_of_codimension_two_of_products_of_maps(tmp_path, y, z, found):
    """A quadratic map beside a linear one with the multiplier c, or c times a rotation: both happen on c = 1 and c = -1."""
    results = run_model(PRODUCT.replace("BLOCK_Y", y).replace("BLOCK_Z", z), tmp_path / "a.h5")
    for name, a in (("LP", -0.25), ("PD", 0.75)):
        step = results.step(name)
        assert sorted(labels(step)) == sorted(found[name])
        assert parameter(step, "a") == pytest.approx(np.full(len(step), a), abs=1e-9)
        assert not any("WARNING" in t for t in step.termination)
        places = sorted(parameter(step, "c", label) for label in labels(step))
        assert places == pytest.approx(sorted(found[name].values()), abs=1e-8)
