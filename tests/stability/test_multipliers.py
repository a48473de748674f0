"""Floquet multipliers against closed forms, exact shooting and measured decay."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.special

from benchmarks import tracking
from pddecont.delay.chain import Chain
from pddecont.delay.chebyshev import Chebyshev
from pddecont.delay.direct import Direct
from pddecont.orbit.curve import settle
from pddecont.orbit.mesh import Mesh, equal_cuts, segment_pieces
from pddecont.orbit.meshing import MeshRule, remeshed
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.stability.multipliers import Known, describe, eigenvector, multipliers
from pddecont.stability.period import linearise
from tests.conftest import numeric_from
from tests.orbits import decay, orbit

# Orbits computed apart from this program: piecewise linear flows by matrix exponentials, shooting in the contact times.
CHAIN_IMPACT = (0.358308645167, 0.167173792274)  # fig. 4.7, N = 15, M = 2, K = 0.12
TWO_IMPACTS = complex(0.70579785930, 0.48192538100)  # K = 0, beta = 29, two impacts in two periods
# Impact oscillator with direct delays, tau_d 3.8, K 0.12 (shared design, section 5.3).
IMPACT = (0.327612842, 0.153421582)
# Mackey-Glass, n = 10, by an independent spectral collocation with step doubling.
MACKEY_GLASS = {1.2: (-0.811229553589, 0.009459062559 + 0.041890997732j), 1.32: (-0.992265846574, 0.049170250738 + 0.045803005762j)}


def own(problem, x, n=None):
    return multipliers(problem, x, n).own


def test_the_impact_oscillator():
    assert own(*tracking.soft())[:2] == pytest.approx(IMPACT, abs=1e-9)


def test_the_chain_against_exact_shooting():
    problem, x = orbit("impact_oscillator", t_end=900, mesh="degree: 8, intervals: 40", delay="method: chain, order: 2, n: 15")
    assert own(problem, x)[:2] == pytest.approx(CHAIN_IMPACT, abs=1e-9)


def test_two_impacts_against_exact_shooting():
    problem, x = orbit("impact_oscillator", "K: 0", 900, initial="x: -0.26, v: 1.74")
    assert own(problem, x)[0] == pytest.approx(TWO_IMPACTS, abs=1e-8)


def test_the_wall():
    """Textbook saltation matrix at the orbit of the shared table (impact at 1.0849389538, outgoing speed -2.4554898724).

    The table's multipliers .716444, .652469 have the same product, e^(-c pi) r^2, but another sum; the sum here is that of the saltation
    matrix, and of differences of the simulated flow over a period (0.6829504 +- 0.0321948 i).
    """
    c, r, t, out = 0.1, 0.8, 1.0849389538, -2.4554898724
    into = -out / r

    def field(v):
        return np.array([v, math.cos(2 * t) - c * v - 0.2])

    jump = np.diag([1.0, -r])
    saltation = jump + np.outer(field(out) - jump @ field(into), [1.0, 0.0]) / into
    exact = scipy.linalg.eigvals(saltation @ scipy.linalg.expm(np.array([[0.0, 1.0], [-1.0, -c]]) * math.pi))
    found = own(*orbit("wall_oscillator", t_end=120))
    assert found == pytest.approx(sorted(exact, key=lambda z: -z.imag), abs=1e-8)


def test_the_bouncing_ball():
    """From the impact map's trace and its determinant r^2, in closed form at G = 0.6, r = 0.8."""
    found = own(*orbit("bouncing_ball", t_end=1200))
    assert found[0] == pytest.approx(0.0294250083611898 + 0.799458672404611j, abs=1e-10)
    assert found[0] * found[1] == pytest.approx(0.64, abs=1e-10)


def at_delay(tau):
    """Return the Mackey-Glass orbit at a delay near its period doubling, where simulations settle slowly."""
    problem, x = orbit("mackey_glass", "n: 10, tau: 1.28", 500)
    p = problem.parameters.copy()
    p[problem.numeric.parameter_index("tau")] = tau
    problem, solution = settle(replace(problem, parameters=p), x, MeshRule(10, tol=1e-11))
    return problem, solution.x


@pytest.mark.parametrize("tau", [1.2, 1.32])
def test_mackey_glass(tau):
    problem, x = at_delay(tau)
    m = multipliers(problem, x)
    assert m.own[:2] == pytest.approx(MACKEY_GLASS[tau], abs=1e-9)
    assert m.trivial_error < 1e-9
    assert "trivial multiplier" in describe(m)


def test_mackey_glass_at_its_period_doubling():
    assert own(*at_delay(1.3249215258))[0] == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.parametrize(("model", "changes"), [
    ("relay", "a: 0.5, tau: 1"), ("on_off_control", "tau: 0.8"), ("spiking_neuron", "tau: 0.4"),
])  # fmt: skip
def test_switching_between_exact_arcs_forgets_everything(model, changes):
    problem, x = orbit(model, changes, 80)
    assert np.max(np.abs(own(problem, x))) < 1e-8


def test_pulsed_control():
    """x' = b x(t - 1), x -> q x at whole numbers: multipliers b / W_k(b / q)."""
    problem, x = orbit("pulsed_control", "b: 0.5, q: 0.55", 400)
    exact = [0.5 / scipy.special.lambertw(0.5 / 0.55, k) for k in (0, 1, -1)]
    assert exact[0] == pytest.approx(0.9375213103, abs=1e-10)
    assert own(problem, x)[0] == pytest.approx(exact[0], abs=1e-10)
    problem, x = orbit("pulsed_control", "b: -1.2, q: 0.8", 300)
    exact = sorted((-1.2 / scipy.special.lambertw(-1.5, k) for k in range(-4, 4)), key=lambda z: (-abs(z), -z.imag))
    assert own(problem, x, 6) == pytest.approx(exact[:6], abs=1e-9)


def test_the_delayed_cosine():
    """x' = -(pi/2) x(t - 1): exp(4 W_k(-pi/2)). The unit pair is one defective double multiplier, so its digits are worth half."""
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {k: 1}\nmodes: {m: {x': -k*pi/2*x(t - 1)}}\n")
    mesh = Mesh(12, 1, segment_pieces(1, 2, equal_cuts([16])))
    theta = np.array([4.0, 1.0])
    values = np.cos(math.pi / 2 * mesh.base_times(theta))[:, None]
    problem = OrbitProblem(numeric, (eventless("m"),), mesh, Direct(), np.array([1.0]), (), 1, values)
    x = problem.layout.join(values, [4.0], 0.0, np.zeros(0))
    m = multipliers(problem, x, 6)
    exact = sorted((abs(np.exp(4 * scipy.special.lambertw(-math.pi / 2, k))) for k in range(-4, 4)), reverse=True)
    assert exact[2:6] == pytest.approx([1.63e-3, 1.63e-3, 1.52e-4, 1.52e-4], rel=0.01)
    assert np.abs(m.values[2:6]) == pytest.approx(exact[2:6], abs=1e-10)
    assert np.abs(m.values[:2]) == pytest.approx([1.0, 1.0], abs=1e-6)
    # What the trivial one leaves of the pair's sum is good to rounding.
    assert m.own[0] == pytest.approx(1.0, abs=1e-10)


def test_the_three_ways_to_discretise_the_delay_agree_as_n_grows():
    exact = MACKEY_GLASS[1.2][0]
    problem, x = orbit("mackey_glass", "n: 10, tau: 1.2", 400)
    assert own(problem, x)[0] == pytest.approx(exact, abs=1e-10)
    rule = MeshRule(8, intervals=24)

    def error(delay):
        found, solution = settle(*remeshed(replace(problem, delay=delay), x, rule), rule)
        return float(abs(own(found, solution.x)[0] - exact))

    chains = [error(Chain(2, n)) for n in (40, 80, 160)]
    assert np.log2(chains[0] / chains[1]) == pytest.approx(2, abs=0.15)
    assert np.log2(chains[1] / chains[2]) == pytest.approx(2, abs=0.05)
    lines = [error(Chebyshev(n)) for n in (10, 15, 20)]
    assert lines[0] > 30 * lines[1] > 900 * lines[2]


@pytest.mark.parametrize(("model", "changes", "n_periods"), [
    ("impact_oscillator", "", 24), ("mackey_glass", "n: 10, tau: 1.2", 130), ("bouncing_ball", "G: 0.5", 120),
    ("pulsed_control", "b: 0.5, q: 0.55", 420), ("wright", "alpha: 1.7", 60), ("impact_oscillator", "K: 0.16", 40),
])  # fmt: skip
def test_decay_measured_by_simulation(model, changes, n_periods):
    problem, x = orbit(model, changes, 900, mesh="degree: 8, tol: 1e-9")
    assert abs(decay(problem, x, n_periods)[0]) == pytest.approx(abs(own(problem, x)[0]), rel=0.01)


def test_decay_where_the_history_jumps():
    """A hard wall with delayed velocity feedback: velocities that jump are read again, and carry the impact times with them."""
    problem, x = tracking.hard()
    found, measured = own(problem, x)[:2], decay(problem, x, 80)
    assert measured[0] == pytest.approx(found[0] if measured[0].imag > 0 else np.conj(found[0]), rel=0.01)


@pytest.mark.parametrize("tau", [1.7, 2.3, 4.1])
def test_many_delayed_events_under_way(tau):
    """The neuron's kicks of w earlier spikes are under way. With spikes at t_k the next comes at

        t_{k+1} = t_{k-w} + tau + G(t_{k-w} + tau - t_k),   G(phi) = ln((drive e^-phi - kick) / (drive - 1))

    so mu^{w+1} = 1 + G' - G' mu^w. Its root 1 is the shift of all spikes, which an orbit with events does not have.
    """
    problem, x = orbit("spiking_neuron", f"tau: {tau}", 200)
    drive, kick = 1.5, -0.1
    w = int(tau // problem.period(x))
    assert w >= 1
    phi = tau - w * problem.period(x)
    slope = -drive * math.exp(-phi) / (drive * math.exp(-phi) - kick)
    roots = np.roots([1.0, slope, *np.zeros(w - 1), -(1.0 + slope)])
    rest = np.delete(roots, np.argmin(np.abs(roots - 1.0)))
    found = own(problem, x, w)
    assert np.sort_complex(found[: len(rest)]) == pytest.approx(np.sort_complex(rest), abs=1e-9)


def test_the_number_of_multipliers_is_the_users():
    problem, x = orbit("mackey_glass", "n: 10, tau: 1.2", 300)
    for n in (1, 3, 7):
        values = multipliers(problem, x, n).values
        # A conjugate pair is not torn apart.
        assert len(values) in (n, n + 1)
        assert np.all(np.diff(np.abs(values)) < 1e-9)
    assert np.all(np.abs(multipliers(problem, x).values) >= 1e-3)


def test_arnoldi_and_the_whole_spectrum_agree(monkeypatch):
    from pddecont.stability import multipliers as module

    problem, x = orbit("impact_oscillator", t_end=900, mesh="degree: 6, intervals: 30", delay="method: chain, order: 2, n: 40")
    whole = multipliers(problem, x, 4).values
    monkeypatch.setattr(module, "DENSE", 0)
    monkeypatch.setattr(module, "DENSE_LINES", 0)
    assert multipliers(problem, x, 4).values == pytest.approx(whole, abs=1e-9)


def test_an_eigenvector_is_one():
    problem, x = tracking.soft()
    period = linearise(problem, x)
    leading = own(problem, x)[0]
    v = eigenvector(problem, x, leading.real)
    assert np.max(np.abs(v)) == 1.0
    values, vectors = np.linalg.eig(period.matrix())
    history = vectors[:, np.argmin(np.abs(values - leading))].real
    now, later = period.step(history[:, None])
    after = period.step(later)[0]
    assert after == pytest.approx(leading.real * now, abs=1e-9 * np.max(np.abs(now)))


def test_multipliers_are_computed_once():
    problem, x = tracking.hard()
    known = Known()
    assert known(problem, x) is known(problem, x)
    assert known(problem, x.copy()) is not known(problem, x)


def test_a_poor_mesh_shows_in_the_trivial_multiplier_and_is_warned_of(tmp_path):
    from pddecont.results.summary import step_summary
    from tests.runs import run

    text = """\
model: van_der_pol
mesh: {degree: 3, intervals: INTERVALS}
steps:
  - {name: t, simulate: {t_end: 60}}
  - {name: o, orbit: {from: t, stability: true}}
"""
    errors = []
    for n in (8, 40):
        step = run(text.replace("INTERVALS", str(n)), tmp_path / "a.h5").step("o")
        errors.append(step.points["trivial_error"][0])
        assert ("WARNING" in step.termination[0].split("trivial multiplier")[1]) == (errors[-1] > 1e-4)
        assert ("warning" in step_summary(step)) == (errors[-1] > 1e-4)
    assert errors[0] > 1e-3
    assert errors[1] < 1e-4


def test_a_jump_that_comes_back_at_its_own_event_is_warned_of(tmp_path):
    """Delayed feedback over exactly one period of a bouncing orbit: the multipliers differ on either side of it."""
    from tests.runs import run_model

    text = """\
name: pyragas
states: [x, v]
parameters: {omega: 2, c: 0.1, wall: 0.2, r: 0.8, K: 0.2, f: FACTOR}
forcing: {period: 2*pi/omega}
modes: {free: {x': v, v': cos(omega*t) - c*v - x + K*(v(t - f*2*pi/omega) - v)}}
events: {hit: x - wall}
resets: {bounce: {v: -r*v}}
segments: {flight: {mode: free, event: hit, direction: rising, reset: bounce, to: free}}
run:
  mesh: {degree: 8, tol: 1e-9}
  steps:
    - {name: t, simulate: {t_end: 300}}
    - {name: o, orbit: {from: t, stability: true}}
"""
    found = {}
    for factor in (1 - 1e-6, 1, 1 + 1e-6):
        step = run_model(text.replace("FACTOR", str(factor)), tmp_path / "a.h5").step("o")
        found[factor] = step.termination[0]
    assert "comes back through a delay just at an event" in found[1]
    assert not any("comes back" in found[factor] for factor in (1 - 1e-6, 1 + 1e-6))


def test_multipliers_of_a_lines_own_stages_are_left_out_or_said_to_hide_the_orbits(tmp_path):
    """Stages far shorter than mesh intervals ring on in the collocated line: what depends on the mesh is no multiplier of the orbit."""
    problem, x = orbit("van_der_pol", t_end=80)
    rule = MeshRule(8, intervals=30)
    direct = own(problem, x, 2)
    seen = {}
    for order, n in ((2, 60), (3, 60), (3, 200)):
        found, solution = settle(*remeshed(replace(problem, delay=Chain(order, n)), x, rule), rule)
        seen[order, n] = multipliers(found, solution.x, 6)
        assert seen[order, n].trivial_error < 1e-6
    assert np.max(np.abs(direct)) < 1e-3
    assert not seen[2, 60].lost and np.max(np.abs(seen[2, 60].own)) < 1e-3
    assert not seen[3, 60].lost and seen[3, 60].noise > 1e-5
    assert seen[3, 200].lost
    assert "WARNING" in describe(seen[3, 200])


def test_a_branch_does_not_start_where_its_multipliers_are_lost(tmp_path):
    from pddecont.errors import ConvergenceError
    from tests.runs import run

    text = """\
model: van_der_pol
mesh: {degree: 8, intervals: 30}
steps:
  - {name: t, simulate: {t_end: 80}}
  - {name: o, orbit: {from: t}}
  - {name: p, delay: {method: chain, order: 3, n: 200}, orbit: {from: o, stability: true}}
  - {name: c, delay: {method: chain, order: 3, n: 200}, continue: {from: p, free: [mu], range: {mu: [0.5, 2]}, stability: true}}
"""
    with pytest.raises(ConvergenceError, match="use more intervals"):
        run(text, tmp_path / "a.h5")
    from pddecont.results.reader import read_results

    step = read_results(tmp_path / "a.h5").step("p")
    assert step.points["stable"][0] == -1
    assert "WARNING" in step.termination[0]
