"""Orbits of the delay equation itself, against closed forms and independent numbers."""

import math

import numpy as np
import pytest

from benchmarks import tracking
from benchmarks.tracking import errors_on_refinement
from pddecont.continuation.arclength import bordered
from pddecont.continuation.newton import NewtonSettings
from pddecont.delay.chain import Chain
from pddecont.delay.direct import Direct
from pddecont.model.document import parse_document
from pddecont.orbit.curve import Curve, settle, sizes_of
from pddecont.orbit.mesh import Mesh, equal_cuts, segment_pieces
from pddecont.orbit.meshing import MeshRule, remeshed
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.results.reader import read_results
from pddecont.steps.loading import load_plan
from pddecont.steps.run import execute
from tests.conftest import ROOT, numeric_from
from tests.problems import (
    GRAZING_TAU,
    IMPACT_SPEED,
    MACKEY_GLASS_PD,
    WRIGHT,
    chain_transfer,
    grazing_amplitude,
    neuron,
    on_off,
    relay,
    turning,
)

FINE = "mesh: {degree: 10, tol: 1e-12}"


def run(text, path):
    """Execute a run on a shipped model and return its results."""
    execute(load_plan(parse_document(text, str(ROOT / "configs" / "test.yaml"))), path, overwrite=True)
    return read_results(path)


def orbit(model, changes, path, t_end=80, mesh=FINE, monitors="", delay="direct"):
    """Return the row of an orbit as a dictionary."""
    from pddecont.results.tables import table

    text = (f"model: {model}\nset: {{{changes}}}\n{mesh}\ndelay: {{method: {delay}}}\nmonitors: {{{monitors}}}\nsteps:\n"
            f"  - {{name: t, simulate: {{t_end: {t_end}}}}}\n  - {{name: o, orbit: {{from: t}}}}\n")  # fmt: skip
    return table(run(text, path / "a.h5").step("o"), "points")[0]


@pytest.fixture(scope="module")
def impact():
    """The impact oscillator's orbit on a fine mesh: problem and unknowns."""
    return tracking.soft()


@pytest.fixture(scope="module")
def wall():
    """The same for a hard wall with delayed feedback."""
    return tracking.hard()


def speed(problem, x):
    return problem.layout.split(x)[0][problem.mesh.last_base[0], 1]


def test_impact_speed_with_few_unknowns(impact):
    problem, x = settle(*remeshed(*impact, MeshRule(9, intervals=20)), MeshRule(9, intervals=20))
    assert len(x.x) < 450
    assert speed(problem, x.x) == pytest.approx(IMPACT_SPEED, abs=1e-10)
    assert speed(*impact) == pytest.approx(IMPACT_SPEED, abs=1e-12)


def errors_of(found):
    return [error for _, error in found]


@pytest.mark.parametrize("degree", [3, 4, 5])
def test_order_with_tracked_breaking_points(impact, degree):
    errors = errors_of(errors_on_refinement(impact, degree, True, (1, 2, 4)))
    orders = -np.diff(np.log2(errors))
    assert orders[-1] > degree + 0.6
    assert np.log2(errors[0] / errors[-1]) / 2 > degree + 0.5


def test_order_after_a_jump_with_tracked_breaking_points(wall):
    errors = errors_of(errors_on_refinement(wall, 4, True, (1, 2, 4)))
    assert np.log2(errors[0] / errors[-1]) / 2 == pytest.approx(5, abs=0.3)
    assert errors_of(errors_on_refinement(wall, 4, False, (32,)))[0] > 1e3 * errors[-1]


def test_order_without_tracking_is_about_three(impact):
    errors = errors_of(errors_on_refinement(impact, 6, False, (10, 20, 40, 80)))
    order = np.log2(errors[0] / errors[-1]) / 3
    assert 1.8 < order < 3.6
    assert errors[-1] > 1e-8


@pytest.mark.parametrize(("degree", "intervals"), [(2, 2), (4, 5), (7, 3)])
def test_relay_of_straight_pieces_is_exact_on_any_mesh(tmp_path, degree, intervals):
    row = orbit("relay", "a: 0, tau: 0.7", tmp_path, 40, f"mesh: {{degree: {degree}, intervals: {intervals}}}", "amp: amplitude(x)")
    assert row["period"] == pytest.approx(2.8, abs=1e-12)
    assert row["amp"] == pytest.approx(0.7, abs=1e-12)


@pytest.mark.parametrize(("a", "tau"), [(0.5, 1.0), (-0.7, 1.3), (0.2, 2.0)])
def test_relay(tmp_path, a, tau):
    row = orbit("relay", f"a: {a}, tau: {tau}", tmp_path, 80 * tau, monitors="amp: amplitude(x)")
    assert (row["period"], row["amp"]) == pytest.approx(relay(a, tau), abs=1e-11)


@pytest.mark.parametrize("tau", [0.8, 2.5])
def test_on_off_control(tmp_path, tau):
    row = orbit("on_off_control", f"tau: {tau}", tmp_path, 60, monitors="high: max(x), low: min(x)")
    assert (row["period"], row["high"], row["low"]) == pytest.approx(on_off(1.5, 0, 1, tau), abs=1e-11)


def test_wright(tmp_path):
    row = orbit("wright", "", tmp_path, 150, monitors="high: max(x)")
    assert row["period"] == pytest.approx(WRIGHT["period"], abs=1e-9)
    assert row["high"] == pytest.approx(WRIGHT["highest"], abs=1e-9)


def test_mackey_glass_at_its_period_doubling(tmp_path):
    """Past the doubling simulations go elsewhere, so the orbit comes from before it."""
    end = MACKEY_GLASS_PD["tau"]
    text = (f"model: mackey_glass\n{FINE}\nsteps:\n  - {{name: t, simulate: {{t_end: 200}}}}\n  - {{name: o, orbit: {{from: t}}}}\n"
            f"  - {{name: c, continue: {{from: o, free: [tau], range: {{tau: [0.9, {end}]}}, direction: up}}}}\n")  # fmt: skip
    step = run(text, tmp_path / "a.h5").step("c")
    assert step.points["period"][step.row("EP1")] == pytest.approx(MACKEY_GLASS_PD["period"], abs=1e-9)


def test_turning_at_the_lobes_lowest_point():
    """The linear equation has orbits of any size exactly on the lobe: with the size given, width of cut and period come out."""
    numeric = numeric_from("name: turning\nstates: [x, v]\nparameters: {zeta: 0.02, w: 0.05, tau: 1}\n"
                           "modes: {cut: {x': v, v': -2*zeta*v - x - w*(x - x(t - tau))}}\n")  # fmt: skip
    W = math.sqrt(1 + 2 * 0.02)
    w, tau = turning(0.02, W)
    assert (w, tau) == pytest.approx((0.0408, 4.6401058748), abs=1e-10)
    mesh = Mesh(10, 1, segment_pieces(1, 2, equal_cuts([12])))
    T = 2 * math.pi / W
    times = mesh.base_times(np.array([T, tau]))
    values = np.stack([np.cos(W * times), -W * np.sin(W * times)], 1)
    p = np.array([0.02, 0.05, tau])
    problem = OrbitProblem(numeric, (eventless("cut"),), mesh, Direct(), p, ("w",), 1, values)
    x = problem.layout.join(values, [T * 1.001], 0.0, [0.0401])
    curve = Curve(problem, sizes_of(problem, x, (1.0,)))
    row = np.zeros(len(x))
    row[0] = 1.0
    solution = bordered(curve, row, 1.0, x, curve.metric(), NewtonSettings())
    assert solution.x[-1] == pytest.approx(w, abs=1e-9)
    assert problem.period(solution.x) == pytest.approx(T, abs=1e-9)


@pytest.mark.parametrize("tau", [0.4, 0.95, 2.3, 7.1])
def test_delayed_kicks_of_which_many_are_under_way(tmp_path, tau):
    row = orbit("spiking_neuron", f"tau: {tau}", tmp_path, 200)
    assert row["period"] == pytest.approx(neuron(1.5, -0.1, tau), abs=1e-11)


def test_kicks_followed_in_their_delay(tmp_path):
    """The kick must come before the next spike would; the branch ends where the two meet and says so."""
    text = (f"model: spiking_neuron\n{FINE}\nsteps:\n  - {{name: t, simulate: {{t_end: 60}}}}\n  - {{name: o, orbit: {{from: t}}}}\n"
            "  - {name: c, continue: {from: o, free: [tau], range: {tau: [0.2, 2]}, direction: up}}\n")
    step = run(text, tmp_path / "a.h5").step("c")
    taus = step.points["parameters"][:, step.meta["parameters"].index("tau")]
    for tau, period in zip(taus, step.points["period"], strict=True):
        if tau < 0.9:
            assert period == pytest.approx(neuron(1.5, -0.1, tau), abs=1e-10)
    assert step.termination[0].startswith("up: stopped at a special point")
    assert step.points["note"][step.row("VS1")].endswith(b"meets spike")


def test_several_delays_in_one_equation(tmp_path):
    """x'' + 0.2 x' + x = 0.3 x(t - 1) - 0.2 v(t - 2.5) + cos(1.1 t): a complex amplitude solves it."""
    text = ("name: m\nstates: [x, v]\nparameters: {w: 1.1, t1: 1, t2: 2.5, t3: 90}\nforcing: {period: 2*pi/w}\n"
            "modes: {m: {x': v, v': cos(w*t) - 0.2*v - x + 0.3*x(t - t1) - 0.2*v(t - t2) + 0.05*x(t - t1 - t3)}}\n"
            "run:\n  mesh: {degree: 10, tol: 1e-12}\n  monitors: {amp: amplitude(x)}\n  steps:\n"
            "    - {name: t, simulate: {t_end: 900}}\n    - {name: o, orbit: {from: t}}\n")  # fmt: skip
    execute(load_plan(parse_document(text, "m.yaml")), tmp_path / "a.h5")
    step = read_results(tmp_path / "a.h5").step("o")
    w = 1.1
    amplitude = abs(1 / (1 - w**2 + 0.2j * w - 0.3 * np.exp(-1j * w) + 0.2j * w * np.exp(-2.5j * w) - 0.05 * np.exp(-91j * w)))
    assert step.points["monitors"][0, 0] == pytest.approx(amplitude, rel=1e-10)


def grazing_rows(step, name):
    column = step.points["parameters"][:, step.meta["parameters"].index(name)]
    return [column[i] for i in step.order if step.labels[i].startswith("GR")]


IMPACT = ("model: impact_oscillator\nmesh: {degree: 10, tol: 1e-11}\nmonitors: {top: max(x)}\nsteps:\n"
          "  - {name: t, simulate: {t_end: 50*2*pi/omega, INIT}}\n  - {name: o, orbit: {from: t}}\n")  # fmt: skip


def test_grazings_of_the_impacting_orbit_on_two_meshes(tmp_path):
    text = (IMPACT.replace(", INIT", "")
            + "  - {name: tau, continue: {from: o, free: [tau_d], range: {tau_d: [3, 5]}}}\n"
            "  - {name: K, continue: {from: o, free: [K], range: {K: [0.05, 0.3]}, direction: up}}\n")
    results = run(text, tmp_path / "a.h5")
    other = run(text.replace("degree: 10, tol: 1e-11", "degree: 8, tol: 1e-10"), tmp_path / "b.h5")
    for name, step in (("tau_d", "tau"), ("K", "K")):
        fine, coarse = grazing_rows(results.step(step), name), grazing_rows(other.step(step), name)
        assert fine == pytest.approx(coarse, abs=1e-9)
        assert len(fine) == (2 if name == "tau_d" else 1)
    assert grazing_rows(results.step("tau"), "tau_d") == pytest.approx([3.2164416411, 4.6951888028], abs=2e-9)


def test_grazings_of_the_free_orbit_are_those_of_the_closed_form(tmp_path):
    text = (IMPACT.replace("50*2*pi/omega, INIT", "100*2*pi/omega, initial: {x: 0, v: -1}").replace("mesh:", "set: {tau_d: 5.5}\nmesh:")
            + "  - {name: tau, continue: {from: o, free: [tau_d], range: {tau_d: [3, 8]}}}\n")
    step = run(text, tmp_path / "a.h5").step("tau")
    # The contact of the impacting orbit vanishes at the one, and the free orbit grazes at the other.
    at = [step.points["parameters"][i, -1] for i in step.order if step.labels[i][:2] in ("GR", "VS")]
    assert np.min(np.abs(np.subtract.outer(at, GRAZING_TAU)), axis=0) == pytest.approx([0, 0], abs=1e-9)
    for i in [i for i in range(len(step)) if step.orbit(i)["signature"].tobytes() == b"(NC)"]:
        tau = step.points["parameters"][i, -1]
        assert step.points["monitors"][i, 0] == pytest.approx(grazing_amplitude(0.12, np.exp(-0.8j * tau)), abs=1e-10)


@pytest.mark.parametrize(("order", "steps"), [(1, (400, 800)), (2, (40, 80)), (3, (20, 40)), (4, (12, 24))])
def test_chain_grazings_converge_to_the_delay_equations_with_their_order(tmp_path, order, steps):
    """On the linear orbit, where the chain's own closed form checks each value too."""
    from scipy.optimize import brentq

    numeric = numeric_from("name: m\nstates: [x, v]\nparameters: {K: 0.12, tau: 4.7007576118}\nforcing: {period: 2*pi/0.8}\n"
                           "modes: {m: {x': v, v': 0.576*sin(0.8*t) - 0.02*v - x + K*(v(t - tau) - v)}}\n")  # fmt: skip
    from pddecont.orbit.curve import solve_orbit
    from pddecont.orbit.monitors import parse_monitor

    mesh = Mesh(8, 1, segment_pieces(1, 2, equal_cuts([16])))
    top = parse_monitor(numeric, "top", "max(x)")
    errors = []

    def closed(n):
        return brentq(lambda tau: grazing_amplitude(0.12, chain_transfer(0.8, tau, order, n)) - 1.26, 4.2, 5.1, xtol=1e-13)

    for n in steps:
        def miss(tau, n=n):
            problem = OrbitProblem(numeric, (eventless("m"),), mesh, Chain(order, n), np.array([0.12, tau]))
            guess = problem.layout.join(np.zeros((mesh.n_base, 2)), [2 * math.pi / 0.8], 0.0, [])
            return top.value(problem, solve_orbit(problem, guess).x) - 1.26

        found = brentq(miss, 4.2, 5.1, xtol=1e-12)
        assert found == pytest.approx(closed(n), abs=1e-9)
        errors.append(abs(found - GRAZING_TAU[0]))
    # These lengths are not yet where the order has settled for every M; the closed form says what it is here and at the limit.
    measured, expected = (math.log2(e[0] / e[1]) for e in (errors, [abs(closed(n) - GRAZING_TAU[0]) for n in steps]))
    assert measured == pytest.approx(expected, abs=0.01)
    limit = math.log2((closed(400) - GRAZING_TAU[0]) / (closed(800) - GRAZING_TAU[0])) if order < 3 else None
    assert (limit or measured) == pytest.approx(order, abs=0.6 if order == 4 else 0.1)


@pytest.mark.slow
def test_the_impacting_orbit_through_every_crossing_of_breaking_points(tmp_path):
    text = ("model: impact_oscillator\nset: {K: 0.01}\nmesh: {degree: 5, tol: 1e-6}\nsteps:\n  - {name: t, simulate: {t_end: "
            "120*2*pi/omega}}\n  - {name: o, orbit: {from: t}}\n  - {name: c, continue: {from: o, free: [tau_d], range: "
            "{tau_d: [0.01, 20]}, max_points: 2000}}\n")  # fmt: skip
    results = run(text, tmp_path / "a.h5")
    step = results.step("c")
    assert [t.split(":")[1].strip().split(";")[0] for t in step.termination] == [f"reached the end of the range, tau_d = {end}"
                                                                                 for end in (0.01, 20)]  # fmt: skip
    # The mesh keeps what each interval adds below the tolerance; all of them together may be a little more.
    assert np.max(step.points["error_estimate"]) <= 2e-6
    assert np.all(step.points["admissible"] == 1)
    taus = step.points["parameters"][step.order, -1]
    assert (taus[0], taus[-1]) == pytest.approx((0.01, 20))
    # Points of the branch are those of the orbit computed plainly on a fine mesh of its own.
    for i in step.order[:: len(step) // 6]:
        again = (f"model: impact_oscillator\nmesh: {{degree: 9, tol: 1e-10}}\nmonitors: {{v: 'at(NC, v)'}}\nsteps:\n"
                 f"  - {{name: o, orbit: {{from: {{file: {tmp_path / 'a.h5'}, step: c, index: {i}}}}}}}\n")
        plain = run(again, tmp_path / "b.h5").step("o")
        fine = plain.points["monitors"][0, 0]
        coarse = step.orbit(i)["states"][np.flatnonzero(step.orbit(i)["segment"] == 0)[-1], 1]
        assert coarse == pytest.approx(fine, abs=10 * step.points["error_estimate"][i])


def test_the_free_orbit_over_the_whole_range_of_delays(tmp_path):
    """Without the wall, so admissible or not: the amplitude is that of the closed form at every delay from 0.01 to 20."""
    text = ("model: impact_oscillator\nmesh: {degree: 10, tol: 1e-11}\neffects: {off: [impact]}\nmonitors: {top: max(x)}\nsteps:\n"
            "  - {name: t, simulate: {t_end: 60*2*pi/omega}, set: {tau_d: 3.8}}\n  - {name: o, set: {tau_d: 3.8}, orbit: {from: t}}\n"
            "  - {name: c, continue: {from: o, free: [tau_d], range: {tau_d: [0.01, 20]}}}\n")  # fmt: skip
    step = run(text, tmp_path / "a.h5").step("c")
    taus = step.points["parameters"][step.order, -1]
    assert (taus[0], taus[-1]) == pytest.approx((0.01, 20))
    exact = [grazing_amplitude(0.12, np.exp(-0.8j * tau)) for tau in taus]
    assert step.points["monitors"][step.order, 0] == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize(("n", "error"), [(6, 1e-3), (9, 1e-6), (12, 1e-9)])
def test_the_chebyshev_line_converges_fast_on_a_smooth_orbit(n, error):
    from pddecont.delay.chebyshev import Chebyshev

    mesh = Mesh(9, 1, segment_pieces(1, 2, equal_cuts([14])))
    theta = np.array([2 * math.pi / 0.8, 3.8])
    u = np.sin(0.8 * mesh.base_times(theta))[:, None]
    values = Chebyshev(n).operator(mesh, theta, 1, mesh.sites).weights.apply(u)[:, 0]
    worst = np.max(np.abs(values - np.sin(0.8 * (mesh.site_times @ theta - 3.8))))
    assert worst < error


@pytest.mark.parametrize("tol", [1e-4, 1e-6, 1e-8])
def test_the_estimate_tells_the_error(impact, tol):
    problem, solution = settle(*remeshed(*impact, MeshRule(6, tol=tol)), MeshRule(6, tol=tol))
    from pddecont.orbit.estimate import error_estimate

    estimate = error_estimate(problem, solution.x)
    true = abs(speed(problem, solution.x) - IMPACT_SPEED)
    assert estimate <= tol
    assert true < 2 * estimate


@pytest.mark.parametrize("turns", [1, 2])
def test_a_delay_of_exactly_so_many_periods(tmp_path, turns):
    """Breaking points collide exactly. After two forcing periods, the orbit's own, the feedback is zero: K does not matter."""
    text = ("model: impact_oscillator\nmesh: {degree: 9, tol: 1e-11}\nmonitors: {v: 'at(NC, v)'}\nsteps:\n"
            "  - {name: t, set: {K: 0}, simulate: {t_end: 250*2*pi/omega}}\n  - {name: plain, set: {K: 0}, orbit: {from: t}}\n"
            f"  - {{name: held, set: {{K: 0.05, tau_d: {turns}*2*pi/omega}}, orbit: {{from: plain}}}}\n")  # fmt: skip
    results = run(text, tmp_path / "a.h5")
    plain, held = (results.step(name).points["monitors"][0, 0] for name in ("plain", "held"))
    if turns == 2:
        assert held == pytest.approx(plain, abs=1e-10)
    else:
        # The half period reads the orbit's other loop: another orbit, the same on another mesh.
        other = run(text.replace("degree: 9, tol: 1e-11", "degree: 7, tol: 1e-10"), tmp_path / "b.h5")
        assert abs(held - plain) > 1e-3
        assert other.step("held").points["monitors"][0, 0] == pytest.approx(held, abs=1e-8)


def test_grazing_in_the_gain_against_the_closed_form(tmp_path):
    """The free orbit followed down in K at tau_d = 3.8: it grazes at K = 0.1774776777."""
    text = ("model: impact_oscillator\nset: {K: 0.3}\nmesh: {degree: 10, tol: 1e-11}\nsteps:\n"
            "  - {name: t, simulate: {t_end: 60*2*pi/omega}}\n  - {name: o, orbit: {from: t}}\n"
            "  - {name: c, continue: {from: o, free: [K], range: {K: [0.05, 0.5]}, direction: down}}\n")
    assert grazing_rows(run(text, tmp_path / "a.h5").step("c"), "K") == pytest.approx([0.1774776777], abs=1e-9)


def test_the_delay_can_be_zero(tmp_path):
    """Followed down to tau = 0 the orbit becomes that of the equation without delay."""
    text = ("model: van_der_pol\nmesh: {degree: 10, tol: 1e-12}\nsteps:\n  - {name: t, simulate: {t_end: 120}}\n"
            "  - {name: o, orbit: {from: t}}\n  - {name: c, continue: {from: o, free: [tau], range: {tau: [0, 2]}, direction: down}}\n"
            "  - {name: t0, set: {tau: 0}, simulate: {t_end: 120}}\n  - {name: o0, set: {tau: 0}, orbit: {from: t0}}\n")
    results = run(text, tmp_path / "a.h5")
    followed = results.step("c")
    assert followed.points["period"][followed.row("EP1")] == pytest.approx(results.step("o0").points["period"][0], abs=1e-9)


def test_a_reset_that_reads_a_delayed_state_never_reads_across_its_jump(tmp_path):
    """x' = 1 - x, at x = 0.8 to q x(t - tau). While tau < T: x0 = q (1 - (1 - x0) exp(tau - T)), T = ln((1 - x0) / 0.2).

    At tau = T the delayed value jumps, and the branch ends there instead of going on with a value from the wrong side.
    """
    text = ("name: m\nstates: [x]\nparameters: {tau: 0.5, q: 0.3}\nmodes: {m: {x': 1 - x}}\nevents: {hit: x - 0.8}\n"
            "resets: {j: {x: q*x(t - tau)}}\nsegments: {s: {mode: m, event: hit, direction: rising, reset: j, to: m}}\n"
            "initial: {x: 0.1}\nrun:\n  mesh: {degree: 8, tol: 1e-11}\n  monitors: {x0: min(x)}\n  steps:\n"
            "    - {name: t, simulate: {t_end: 60}}\n    - {name: o, orbit: {from: t}}\n"
            "    - {name: c, continue: {from: o, free: [tau], range: {tau: [0.1, 6]}}}\n")  # fmt: skip
    execute(load_plan(parse_document(text, "m.yaml")), tmp_path / "a.h5")
    step = read_results(tmp_path / "a.h5").step("c")
    assert "across a jump" in step.termination[1] or "too sharply" in step.termination[1]
    for (tau, q), T, (x0,) in zip(step.points["parameters"], step.points["period"], step.points["monitors"], strict=True):
        assert tau < T
        assert math.log((1 - x0) / 0.2) == pytest.approx(T, abs=1e-9)
        assert q * (1 - (1 - x0) * math.exp(tau - T)) == pytest.approx(x0, abs=1e-9)
    assert step.points["parameters"][:, 0].max() == pytest.approx(math.log(5), abs=1e-3)
