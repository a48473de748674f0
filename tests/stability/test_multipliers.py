"""Floquet multipliers against closed forms, exact shooting and measured decay."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.special

from pddecont.collocation import Mesh, MeshRule, equal_cuts
from pddecont.delay import Chain, Chebyshev, Direct
from pddecont.orbit import Orbit, OrbitProblem, Signature, adapt_mesh, make_eventless, solve_orbit
from pddecont.stability import MultiplierCache, find_eigenvector, find_multipliers
from pddecont.stability import candidates as module
from pddecont.stability.monodromy import linearise_period
from tests.conftest import numeric_from
from tests.known_orbits import hard_wall, impact_oscillator
from tests.orbits import measure_decay, segment_pieces, settle_to_orbit
from tests.stability.long_delays import (
    damped_wall,
    find_lambert_multipliers,
    find_saltation_multipliers,
    linear_feedback,
)

# Orbits computed apart from this program: piecewise linear flows by matrix exponentials, shooting in the contact times.
CHAIN_IMPACT = (0.358308645167, 0.167173792274)  # fig. 4.7, N = 15, M = 2, K = 0.12
TWO_IMPACTS = complex(0.70579785930, 0.48192538100)  # K = 0, beta = 29, two impacts in two periods
# Impact oscillator with direct delays, tau_d 3.8, K 0.12.
IMPACT = (0.327612842, 0.153421582)
# Mackey-Glass, n = 10, by an independent spectral collocation with step doubling.
MACKEY_GLASS = {
    1.2: (-0.811229553589, 0.009459062559 + 0.041890997732j),
    1.32: (-0.992265846574, 0.049170250738 + 0.045803005762j),
}


def nontrivial(orbit, n=None):
    return find_multipliers(orbit, n).nontrivial


def test_the_impact_oscillator():
    assert nontrivial(impact_oscillator())[:2] == pytest.approx(IMPACT, abs=1e-9)


def test_the_chain_against_exact_shooting():
    delay = {"method": "chain", "order": 2, "n": 15}
    orbit = settle_to_orbit("impact_oscillator", t_end=900, mesh={"degree": 8, "intervals": 40}, delay=delay)
    assert nontrivial(orbit)[:2] == pytest.approx(CHAIN_IMPACT, abs=1e-9)


def test_two_impacts_against_exact_shooting():
    orbit = settle_to_orbit("impact_oscillator", {"K": 0}, 900, initial={"x": -0.26, "v": 1.74})
    assert nontrivial(orbit)[0] == pytest.approx(TWO_IMPACTS, abs=1e-8)


def test_the_wall():
    """Textbook saltation matrix at the orbit of the shared table (impact at 1.0849389538, outgoing speed
    -2.4554898724).

    The table's multipliers .716444, .652469 have the same product, e^(-c pi) r^2, but another sum; the sum here is that
    of the saltation matrix, and of differences of the simulated flow over a period (0.6829504 +- 0.0321948 i).
    """
    c, r, t, out = 0.1, 0.8, 1.0849389538, -2.4554898724
    into = -out / r

    def field(v):
        return np.array([v, math.cos(2 * t) - c * v - 0.2])

    jump = np.diag([1.0, -r])
    saltation = jump + np.outer(field(out) - jump @ field(into), [1.0, 0.0]) / into
    exact = scipy.linalg.eigvals(saltation @ scipy.linalg.expm(np.array([[0.0, 1.0], [-1.0, -c]]) * math.pi))
    found = nontrivial(settle_to_orbit("wall_oscillator", t_end=120))
    assert found == pytest.approx(sorted(exact, key=lambda z: -z.imag), abs=1e-8)


def test_the_bouncing_ball():
    """From the impact map's trace and its determinant r^2, in closed form at G = 0.6, r = 0.8."""
    found = nontrivial(settle_to_orbit("bouncing_ball", t_end=1200))
    assert found[0] == pytest.approx(0.0294250083611898 + 0.799458672404611j, abs=1e-10)
    assert found[0] * found[1] == pytest.approx(0.64, abs=1e-10)


def at_delay(tau):
    """Return the Mackey-Glass orbit at a delay near its period doubling, where simulations settle slowly."""
    orbit = settle_to_orbit("mackey_glass", {"n": 10, "tau": 1.28}, 500)
    p = orbit.parameters.copy()
    p[orbit.numeric.parameter_index("tau")] = tau
    return solve_orbit(Orbit(replace(orbit.problem, parameters=p), orbit.x), MeshRule(10, tol=1e-11)).at.orbit


@pytest.mark.parametrize("tau", [1.2, 1.32])
def test_mackey_glass(tau):
    m = find_multipliers(at_delay(tau))
    assert m.nontrivial[:2] == pytest.approx(MACKEY_GLASS[tau], abs=1e-9)
    assert m.trivial_error < 1e-9


def test_mackey_glass_at_its_period_doubling():
    assert nontrivial(at_delay(1.3249215258))[0] == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("model", "changes"),
    [("relay", {"a": 0.5, "tau": 1}), ("on_off_control", {"tau": 0.8}), ("spiking_neuron", {"tau": 0.4})],
)
def test_switching_between_exact_arcs_forgets_everything(model, changes):
    assert np.max(np.abs(nontrivial(settle_to_orbit(model, changes, 80)))) < 1e-8


def test_pulsed_control():
    """x' = b x(t - 1), x -> q x at whole numbers: multipliers b / W_k(b / q)."""
    orbit = settle_to_orbit("pulsed_control", {"b": 0.5, "q": 0.55}, 400)
    exact = [0.5 / scipy.special.lambertw(0.5 / 0.55, k) for k in (0, 1, -1)]
    assert exact[0] == pytest.approx(0.9375213103, abs=1e-10)
    assert nontrivial(orbit)[0] == pytest.approx(exact[0], abs=1e-10)
    orbit = settle_to_orbit("pulsed_control", {"b": -1.2, "q": 0.8}, 300)
    exact = sorted((-1.2 / scipy.special.lambertw(-1.5, k) for k in range(-4, 4)), key=lambda z: (-abs(z), -z.imag))
    assert nontrivial(orbit, 6) == pytest.approx(exact[:6], abs=1e-9)


def test_the_delayed_cosine():
    """x' = -(pi/2) x(t - 1): exp(4 W_k(-pi/2)). The unit pair is one defective double multiplier, so its digits are
    worth half.
    """
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {k: 1}\nmodes: {m: {x': -k*pi/2*x(t - 1)}}\n")
    mesh = Mesh(12, 1, segment_pieces(1, 2, equal_cuts([16])))
    theta = np.array([4.0, 1.0])
    values = np.cos(math.pi / 2 * mesh.base_times(theta))[:, None]
    signature = Signature(numeric, (make_eventless(numeric.model, "m"),))
    problem = OrbitProblem(signature, mesh, Direct(), np.array([1.0]), reference=values)
    m = find_multipliers(Orbit(problem, problem.unknowns.join(values, [4.0], 0.0, np.zeros(0))), 6)
    exact = sorted((abs(np.exp(4 * scipy.special.lambertw(-math.pi / 2, k))) for k in range(-4, 4)), reverse=True)
    assert exact[2:6] == pytest.approx([1.63e-3, 1.63e-3, 1.52e-4, 1.52e-4], rel=0.01)
    assert np.abs(m.values[2:6]) == pytest.approx(exact[2:6], abs=1e-10)
    assert np.abs(m.values[:2]) == pytest.approx([1.0, 1.0], abs=1e-6)
    # What the trivial one leaves of the pair's sum is good to rounding.
    assert m.nontrivial[0] == pytest.approx(1.0, abs=1e-10)


def with_delay(orbit, delay, rule):
    """Return the orbit with another way to discretise its delays."""
    return solve_orbit(adapt_mesh(Orbit(replace(orbit.problem, delay=delay), orbit.x), rule), rule).at.orbit


def test_the_three_ways_to_discretise_the_delay_agree_as_n_grows():
    exact = MACKEY_GLASS[1.2][0]
    orbit = settle_to_orbit("mackey_glass", {"n": 10, "tau": 1.2}, 400)
    assert nontrivial(orbit)[0] == pytest.approx(exact, abs=1e-10)
    rule = MeshRule(8, intervals=24)

    def error(delay):
        return float(abs(nontrivial(with_delay(orbit, delay, rule))[0] - exact))

    chains = [error(Chain(2, n)) for n in (40, 80, 160)]
    assert np.log2(chains[0] / chains[1]) == pytest.approx(2, abs=0.15)
    assert np.log2(chains[1] / chains[2]) == pytest.approx(2, abs=0.05)
    lines = [error(Chebyshev(n)) for n in (10, 15, 20)]
    assert lines[0] > 30 * lines[1] > 900 * lines[2]


@pytest.mark.parametrize(
    ("model", "changes", "n_periods"),
    [
        ("impact_oscillator", {}, 24),
        ("mackey_glass", {"n": 10, "tau": 1.2}, 130),
        ("bouncing_ball", {"G": 0.5}, 120),
        ("pulsed_control", {"b": 0.5, "q": 0.55}, 420),
        ("wright", {"alpha": 1.7}, 60),
        ("impact_oscillator", {"K": 0.16}, 40),
    ],
)
def test_decay_measured_by_simulation(model, changes, n_periods):
    orbit = settle_to_orbit(model, changes, 900, mesh={"degree": 8, "tol": 1e-9})
    assert abs(measure_decay(orbit, n_periods)[0]) == pytest.approx(abs(nontrivial(orbit)[0]), rel=0.01)


def test_decay_where_the_history_jumps():
    """A hard wall with delayed velocity feedback: velocities that jump are read again, and carry the impact times with
    them.
    """
    found, measured = nontrivial(hard_wall())[:2], measure_decay(hard_wall(), 80)
    assert measured[0] == pytest.approx(found[0] if measured[0].imag > 0 else np.conj(found[0]), rel=0.01)


@pytest.mark.parametrize("tau", [1.7, 2.3, 4.1])
def test_many_delayed_events_under_way(tau):
    """The neuron's kicks of w earlier spikes are under way. With spikes at t_k the next comes at

        t_{k+1} = t_{k-w} + tau + G(t_{k-w} + tau - t_k),   G(phi) = ln((drive e^-phi - kick) / (drive - 1))

    so mu^{w+1} = 1 + G' - G' mu^w. Its root 1 is the shift of all spikes, which an orbit with events does not have.
    """
    orbit = settle_to_orbit("spiking_neuron", {"tau": tau}, 200)
    drive, kick = 1.5, -0.1
    w = int(tau // orbit.period)
    assert w >= 1
    phi = tau - w * orbit.period
    slope = -drive * math.exp(-phi) / (drive * math.exp(-phi) - kick)
    roots = np.roots([1.0, slope, *np.zeros(w - 1), -(1.0 + slope)])
    rest = np.delete(roots, np.argmin(np.abs(roots - 1.0)))
    found = nontrivial(orbit, w)
    assert np.sort_complex(found[: len(rest)]) == pytest.approx(np.sort_complex(rest), abs=1e-9)


def test_the_number_of_multipliers_is_the_users():
    orbit = settle_to_orbit("mackey_glass", {"n": 10, "tau": 1.2}, 300)
    for n in (1, 3, 7):
        values = find_multipliers(orbit, n).values
        # A conjugate pair is not torn apart.
        assert len(values) in (n, n + 1)
        assert np.all(np.diff(np.abs(values)) < 1e-9)
    assert np.all(np.abs(find_multipliers(orbit).values) >= 1e-3)


def test_arnoldi_and_the_whole_spectrum_agree(monkeypatch):
    delay = {"method": "chain", "order": 2, "n": 40}
    orbit = settle_to_orbit("impact_oscillator", t_end=900, mesh={"degree": 6, "intervals": 30}, delay=delay)
    whole = find_multipliers(orbit, 4).values
    monkeypatch.setattr(module, "DENSE", 0)
    monkeypatch.setattr(module, "DENSE_LINES", 0)
    assert find_multipliers(orbit, 4).values == pytest.approx(whole, abs=1e-9)


def test_an_eigenvector_is_one():
    orbit = impact_oscillator()
    monodromy = linearise_period(orbit)
    leading = nontrivial(orbit)[0]
    v = find_eigenvector(orbit, leading.real)
    assert np.max(np.abs(v)) == 1.0
    values, vectors = np.linalg.eig(monodromy.to_matrix())
    history = vectors[:, np.argmin(np.abs(values - leading))].real
    now, later = monodromy.step(history[:, None])
    after = monodromy.step(later)[0]
    assert after == pytest.approx(leading.real * now, abs=1e-9 * np.max(np.abs(now)))
    moved = now[: len(v), 0]
    assert v == pytest.approx(moved / moved[np.argmax(np.abs(moved))], abs=1e-9)


def test_multipliers_are_computed_once():
    orbit, cache = hard_wall(), MultiplierCache()
    assert cache.find(orbit) is cache.find(orbit)
    other = cache.find(Orbit(orbit.problem, orbit.x.copy()))
    assert other is not cache.find(orbit)
    assert np.array_equal(other.values, find_multipliers(orbit).values)


@pytest.mark.parametrize("n", [5.3, 7.3, 50.3])
def test_a_delay_that_nothing_depends_on_leaves_the_multipliers_alone(n):
    orbit = damped_wall(n)
    for number in (2, 5, 12):
        found = find_multipliers(orbit, number)
        assert found.counted
        assert found.nontrivial[:2] == pytest.approx(find_saltation_multipliers(orbit), abs=1e-7)
        # The second entry of the history is rounding: no pseudo-eigenvalue of the long shift is left.
        assert np.max(np.abs(found.values[2:]), initial=0.0) < 1e-6


@pytest.mark.parametrize(("n", "K"), [(5.3, 0.1), (20.3, 0.5), (50.3, 0.9), (49.8, -0.8)])
def test_delays_of_many_periods_against_the_lambert_function(n, K):
    orbit = linear_feedback(n, K)
    exact = np.array(find_lambert_multipliers(n, K, 12))
    for number in (6, 12) if n < 40 else (12,):
        found = find_multipliers(orbit, number)
        assert found.counted and np.max(found.residuals) < 1e-11
        assert found.values[:number] == pytest.approx(exact[:number], abs=1e-8)


def test_the_leading_ones_are_the_same_however_many_are_asked_for():
    orbit = damped_wall(7.3, 0.05)
    most = find_multipliers(orbit, 30)
    assert most.counted
    for n in (2, 8, 12):
        found = find_multipliers(orbit, n)
        assert found.values == pytest.approx(most.values[: len(found.values)], abs=1e-10)
        assert MultiplierCache(n).find(orbit).n_unstable == most.n_unstable


UNITS_MODEL = {
    "name": "units",
    "states": ["x", "v"],
    "forcing": {"period": "2*pi/om"},
    "modes": {"m": {"x'": "v", "v'": "F*cos(om*t) - c*v - w0*x + K*x(t - tau) + q*v(t - tau2)"}},
    "events": {"h": "x - wall"},
    "resets": {"b": {"v": "-r*v + g*v(t - tau2)"}},
    "segments": {"s": {"mode": "m", "event": "h", "direction": "rising", "reset": "b", "to": "m"}},
}


def in_units(length, time):
    """Return the orbit of an oscillator at a wall with two delays, one of 1.5 periods, in other units."""
    parameters = {
        "om": 2.4784 / time,
        "c": 0.1219 / time,
        "w0": 1 / time**2,
        "F": length / time**2,
        "wall": -0.092 * length,
        "r": 0.8035,
        "K": 0.0523 / time**2,
        "q": -0.1652 / time,
        "tau": 3.8086 * time,
        "tau2": 0.8647 * time,
        "g": -0.04956,
    }
    initial = {"x": -0.142 * length, "v": -0.1 * length / time}
    model = {**UNITS_MODEL, "parameters": parameters, "initial": {"mode": "m", **initial}}
    return settle_to_orbit(model, t_end=380.276709198248 * time, mesh={"degree": 8, "tol": 1e-9}, atol=1e-11 * length)


def test_units_change_no_multiplier():
    """The values are those of a linearisation apart from this program, with saltation matrices."""
    exact = [0.36760208 + 0.79027076j, -0.06485787, 0.0321132 + 0.0199483j, -0.0157082 + 0.0127926j]
    plain = find_multipliers(in_units(1.0, 1.0))
    assert plain.values[[0, 2, 3, 5]] == pytest.approx(exact, abs=1e-6)
    for length, time in ((1e-6, 1.0), (1e6, 1.0), (1e-6, 1e6), (1.0, 1e-6)):
        found = find_multipliers(in_units(length, time))
        assert found.counted and found.values[:9] == pytest.approx(plain.values[:9], abs=1e-8)
