"""Special points of branches against closed forms and independent calculations, and branch switching."""

import math

import numpy as np
import pytest

from tests.runs import labels, monitor, multipliers, parameter, run, run_model

# Harmonic balance with 30 and 45 harmonics, confirmed by shooting: folds of Duffing's response at F = 1.
DUFFING_FOLDS = (1.63530555133761, 2.21316595462876)
# Piecewise linear flows by matrix exponentials.
TWO_IMPACT_FOLD = 26.5224937149  # in beta, K = 0
TWO_IMPACT_FOLD_CHAIN = 0.00383651621681  # in K, beta = 29, N = 15, M = 2
CHAIN_COLLAPSE = 0.174892118771  # period-2 orbit with two impacts falls onto the period-1 orbit, tau_d = 3.8
CHAIN_GRAZING = 0.174746955369
# Impact map of the bouncing ball in closed form and by Newton's method, r = 0.8.
BALL_PD = 1.07083646824791
BALL_SECOND_PD = 1.22177969954674
MACKEY_GLASS_PD = 1.32492152576

BALL = """\
model: bouncing_ball
mesh: {degree: 8, tol: 1e-10}
steps:
  - {name: t, simulate: {t_end: 200*2*pi}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [G], range: {G: [0.3, 1.2]}, stability: true, step: {max: MAX}}}
"""


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    text = BALL.replace("MAX", "0.1") + """\
  - {name: twice, continue: {from: {step: c, point: PD1}, branch: switch, free: [G], range: {G: [0.3, 1.3]}, stability: true}}
"""
    return run(text, tmp_path_factory.mktemp("ball") / "a.h5")


def test_fold_and_doubling_of_the_ball(ball):
    step = ball.step("c")
    assert labels(step) == ["LP1", "PD1"] or labels(step) == ["PD1", "LP1"]
    assert parameter(step, "G", "LP1") == pytest.approx(math.pi * 0.2 / 1.8, abs=1e-12)
    assert parameter(step, "G", "PD1") == pytest.approx(BALL_PD, abs=1e-10)
    exact = math.sqrt(math.pi**2 * (0.2 / 1.8) ** 2 + 4 * (1 + 0.64) ** 2 / 1.8**4)
    assert exact == pytest.approx(BALL_PD, abs=1e-12)
    assert multipliers(step, step.row("PD1")) == pytest.approx([-1.0, -0.64], abs=1e-9)


def test_stability_along_the_ball(ball):
    """Stable between fold and doubling on one side of the fold, a saddle on the other."""
    step = ball.step("c")
    G = step.points["parameters"][:, 0]
    saddle = np.array([np.max(np.abs(multipliers(step, i))) > 1 and np.max(multipliers(step, i).real) > 1 for i in range(len(step))])
    ordinary = np.array([not k for k in step.points["kind"]])
    assert np.all(step.points["stable"][ordinary & ~saddle & (G < BALL_PD)] == 1)
    assert np.all(step.points["stable"][ordinary & ~saddle & (G > BALL_PD)] == 0)
    assert np.all(step.points["n_unstable"][ordinary & saddle] == 1)
    assert 3 < np.sum(saddle) < len(step) - 3


def test_the_doubled_ball(ball):
    step = ball.step("twice")
    assert labels(step) == ["PD1"]
    assert parameter(step, "G", "PD1") == pytest.approx(BALL_SECOND_PD, abs=1e-9)
    assert multipliers(step, step.row("PD1")) == pytest.approx([-1.0, -(0.8**4)], abs=1e-7)
    assert step.points["period"][-1] == pytest.approx(4 * math.pi)
    assert np.all(np.diff(parameter(step, "G")) > 0)
    orbit = step.orbit(len(step) - 1)
    first, second = (orbit["states"][orbit["segment"] == s][0, 1] for s in (0, 1))
    assert abs(first - second) > 0.05


@pytest.mark.parametrize("most", [0.03, 0.25, 0.8])
def test_no_point_is_missed_or_invented_by_large_steps(tmp_path, most):
    step = run(BALL.replace("MAX", f"{most}, initial: 0.02"), tmp_path / "a.h5").step("c")
    assert sorted(labels(step)) == ["LP1", "PD1"]
    assert parameter(step, "G", "PD1") == pytest.approx(BALL_PD, abs=1e-10)


def test_folds_of_duffings_response(tmp_path):
    text = """\
model: duffing
mesh: {degree: 8, tol: 1e-9}
monitors: {x_max: max(x)}
steps:
  - {name: t, simulate: {t_end: 40*2*pi/omega}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [omega], range: {omega: [1, 2.5]}, direction: up, events_along: {level: x_max - 2}}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    folds = [parameter(step, "omega", name) for name in labels(step) if name.startswith("LP")]
    assert sorted(folds) == pytest.approx(DUFFING_FOLDS, abs=1e-9)
    # No multipliers were asked for, and none computed.
    assert np.all(step.points["stable"] == -1)
    assert len(step.orbits["multipliers"]) == 0
    level = [name for name in labels(step) if name.startswith("UF")]
    assert len(level) == 2
    for name in level:
        assert monitor(step, "x_max", name) == pytest.approx(2, abs=1e-9)
        assert step.points["note"][step.row(name)] == b"level"


PITCHFORK = """\
name: pitchfork
states: [x, y]
parameters: {a: -0.4, b: 0}
forcing: {period: 1}
modes: {m: {x': a*x + b*x**2 - x**3 + x*y, y': cos(2*pi*t) - y}}
run:
  mesh: {degree: 8, tol: 1e-10}
  monitors: {x: mean(x)}
  steps:
    - {name: t, simulate: {t_end: 40}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [a], range: {a: [-0.5, 0.5]}, stability: true}}
    - {name: other, continue: {from: {step: c, point: BP1}, branch: switch, free: [a], range: {a: [-0.5, 0.5]}, stability: true}}
"""


@pytest.mark.parametrize("b", [0.0, 0.7])
def test_branch_points_and_the_branch_that_crosses(tmp_path, b):
    """x = 0 has the multiplier exp(a), so branches cross at a = 0: a pitchfork for b = 0, else a transcritical point."""

    results = run_model(PITCHFORK.replace("b: 0}", f"b: {b}}}"), tmp_path / "a.h5")
    step, other = results.step("c"), results.step("other")
    assert labels(step) == ["BP1"]
    assert parameter(step, "a", "BP1") == pytest.approx(0, abs=1e-8)
    at = np.argsort(parameter(step, "a"))
    for i in step.order[at][:: max(1, len(step) // 5)]:
        a = step.points["parameters"][i, 0]
        assert np.min(np.abs(multipliers(step, i) - math.exp(a))) < 1e-8
    x = monitor(other, "x")
    assert np.max(np.abs(x)) > 0.3
    a = parameter(other, "a")
    if b == 0.0:
        assert np.all(a > -1e-6)
        assert np.max(x) > 0.3 and np.min(x) < -0.3
    else:
        assert np.min(a) < -0.05


def test_mackey_glass_doubles(tmp_path):
    text = """\
model: mackey_glass
set: {n: 10, tau: 1.2}
mesh: {degree: 9, tol: 1e-10}
steps:
  - {name: t, simulate: {t_end: 300}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [tau], range: {tau: [0.475, 1.5]}, stability: true}}
  - {name: twice, continue: {from: {step: c, point: PD1}, branch: switch, free: [tau], range: {tau: [1, 1.5]}, stability: true}}
"""
    results = run(text, tmp_path / "a.h5")
    step, twice = results.step("c"), results.step("twice")
    assert labels(step) == ["PD1"]
    assert parameter(step, "tau", "PD1") == pytest.approx(MACKEY_GLASS_PD, abs=1e-9)
    assert step.points["period"][step.row("PD1")] == pytest.approx(3.9196496081, abs=1e-9)
    # The orbit is born at the Hopf point tau = .4708196289 with period 2 pi / Im; near it the amplitude grows as a square root.
    assert step.points["trivial_error"].max() < 1e-8
    assert twice.points["period"][1] == pytest.approx(2 * 3.9196496081, rel=0.02)
    assert np.all(twice.points["stable"][1:] == 1)
    assert np.all(np.diff(parameter(twice, "tau")) > 0)


def test_the_hopf_point_of_mackey_glass(tmp_path):
    """Where the orbit dies its squared amplitude is zero; tau there against the characteristic equation (shared table)."""
    text = """\
model: mackey_glass
set: {n: 10, tau: 0.6}
mesh: {degree: 9, tol: 1e-11}
monitors: {amp: amplitude(x)}
steps:
  - {name: t, simulate: {t_end: 400}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [tau], range: {tau: [0.4709, 0.6]}, direction: down, step: {max: 0.02}}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    tau, squared = parameter(step, "tau"), monitor(step, "amp") ** 2
    near = squared < 0.002
    assert np.sum(near) > 3
    assert np.polynomial.Polynomial.fit(squared[near], tau[near], 3)(0.0) == pytest.approx(0.4708196289, abs=1e-7)


def test_the_orbit_with_two_impacts_really_ends_in_a_fold(tmp_path):
    text = """\
model: impact_oscillator
set: {K: 0, beta: 60}
mesh: {degree: 8, tol: 1e-10}
steps:
  - {name: t, simulate: {initial: {x: 0.04, v: -0.92}, t_end: 120*2*pi/omega}}
  - {name: o, orbit: {from: t, signature: [NC, C, NC, C]}}
  - {name: c, continue: {from: o, free: [beta], range: {beta: [20, 70]}, step: {max: 0.05}, stability: true}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["LP1"]
    assert parameter(step, "beta", "LP1") == pytest.approx(TWO_IMPACT_FOLD, abs=1e-8)
    assert multipliers(step, step.row("LP1"))[:2] == pytest.approx([1.0, 0.7304026910], abs=1e-6)
    assert np.all(step.points["admissible"] == 1)
    assert sorted(set(step.points["n_unstable"][step.points["kind"] == b""])) == [0, 1]


def test_torus_of_the_pulsed_control(tmp_path):
    text = """\
model: pulsed_control
mesh: {degree: 9, tol: 1e-10}
steps:
  - {name: t, simulate: {t_end: 200}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [b], range: {b: [-2.2, -0.5]}, stability: true}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["TR1"]
    assert parameter(step, "b", "TR1") == pytest.approx(-1.71579076378486, abs=1e-10)
    pair = multipliers(step, step.row("TR1"))[:2]
    assert np.abs(pair) == pytest.approx([1.0, 1.0], abs=1e-10)
    assert np.angle(pair[0]) == pytest.approx(1.70121865161311, abs=1e-9)


SYMMETRIC = """\
name: symmetric
states: [x, v]
parameters: {omega: 1.2, c: 0.3, r: 0.9, K: 0.1, tau: 0.5, g: 1}
forcing: {period: 2*pi/omega}
modes: {free: {x': v, v': cos(omega*t) - c*v + K*v(t - tau)}}
events: {R: x - g, L: x + g}
resets: {b: {v: -r*v}}
segments:
  R: {mode: free, event: R, direction: rising, reset: b, to: free}
  L: {mode: free, event: L, direction: falling, reset: b, to: free}
initial: {x: 0.1, v: 0.5}
run:
  mesh: {degree: 8, tol: 1e-9}
  monitors: {m: mean(x)}
  steps:
    - {name: t, simulate: {t_end: 400}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [omega], range: {omega: [1.05, 1.4]}, stability: true, step: {max: 0.1}}}
    - {name: small, continue: {from: o, free: [omega], range: {omega: [1.08, 1.25]}, stability: true, step: {max: 0.03}}}
    - {name: d, continue: {from: {step: c, point: BP1}, branch: switch, free: [omega], range: {omega: [1.09, 1.4]}, step: {max: 0.02}}}
"""


def test_a_symmetric_orbit_between_two_walls_loses_its_symmetry(tmp_path):
    """At the branch point no orbit can be corrected; its place does not depend on the steps, and the new orbits mirror each other."""
    results = run_model(SYMMETRIC, tmp_path / "a.h5")
    step = results.step("c")
    assert labels(step) == ["BP1"]
    assert not any("WARNING" in t for t in step.termination)
    at = parameter(step, "omega", "BP1")
    assert parameter(results.step("small"), "omega", "BP1") == pytest.approx(at, abs=1e-8)
    assert np.min(np.abs(multipliers(step, step.row("BP1")) - 1.0)) < 1e-6
    m, omega = monitor(results.step("d"), "m"), parameter(results.step("d"), "omega")
    assert np.max(m) > 0.05
    assert np.max(m) == pytest.approx(-np.min(m), abs=1e-8)
    assert np.max(omega) < at + 1e-6
    # The squared asymmetry grows in proportion to the distance from the branch point.
    near = (np.abs(m) < 0.06) & (np.abs(m) > 1e-6)
    assert np.sum(near) > 6
    # Extrapolated to none: a quadratic over a wider range misses by 6e-5, this cubic by 1e-6.
    assert np.polynomial.Polynomial.fit(m[near] ** 2, omega[near], 3)(0.0) == pytest.approx(at, abs=3e-6)


def test_three_branch_points_of_a_symmetric_oscillator(tmp_path):
    text = """\
name: cubic
states: [x, v]
parameters: {w: 1.2}
forcing: {period: 2*pi/w}
modes: {m: {x': v, v': cos(w*t) - 0.2*v - x**3}}
initial: {x: 0.1, v: 0.5}
run:
  mesh: {degree: 8, tol: 1e-9}
  steps:
    - {name: t, simulate: {t_end: 400}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [w], range: {w: [0.32, 1.4]}, stability: true}}
"""
    step = run_model(text, tmp_path / "a.h5").step("c")
    assert sorted(labels(step)) == ["BP1", "BP2", "BP3", "LP1", "LP2"]
    assert not any("WARNING" in t for t in step.termination)
    for name in ("BP1", "BP2", "BP3"):
        assert np.min(np.abs(multipliers(step, step.row(name)) - 1.0)) < 1e-5


def test_a_curve_may_start_at_the_edge_of_its_range(ball, tmp_path):
    text = BALL.split("steps:")[0] + f"""\
steps:
  - name: pd
    continue: {{from: {{file: {ball.path}, step: c, point: PD1}}, free: [r, G], range: {{r: [0.5, 0.8], G: [0.3, 3]}}, direction: down}}
"""
    step = run(text, tmp_path / "a.h5").step("pd")
    assert parameter(step, "r")[-1] == pytest.approx(0.8, abs=1e-12)
    assert len(step) > 5
