"""Where orbits of the impact oscillator graze, and how far they reach in the delay, against closed forms."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pddecont.collocation import Mesh, MeshRule, equal_cuts
from pddecont.delay import Chain
from pddecont.orbit import Orbit, OrbitProblem, Signature, make_eventless, parse_monitor, solve_orbit
from pddecont.tables import describe_endings
from tests.conftest import numeric_from
from tests.orbits import segment_pieces
from tests.problems import GRAZING_TAU, chain_transfer, grazing_amplitude
from tests.runs import run
from tests.test_delay_equation import start


def grazing_rows(step, name):
    column = step.points["parameters"][:, step.meta["parameters"].index(name)]
    return [column[i] for i in step.order if step.labels[i].startswith("GR")]


def impacting(steps, begin, *, mesh=None, changes=None):
    """Return a run of the impact oscillator from an orbit on."""
    rest = {"set": changes or {}, "mesh": mesh or {"degree": 10, "tol": 1e-11}, "monitors": {"top": "max(x)"}}
    branches = [
        {"name": name, "continue": {"from": "o", "free": list(ranges), "range": ranges, **more}}
        for name, ranges, more in steps
    ]
    return {"model": "impact_oscillator", **rest, "steps": [*begin, *branches]}


def test_grazings_of_the_impacting_orbit_on_two_meshes(tmp_path):
    begin = start("50*2*pi/omega")
    steps = [("tau", {"tau_d": [3, 5]}, {}), ("K", {"K": [0.05, 0.3]}, {"direction": "up"})]
    results = run(impacting(steps, begin), tmp_path / "a.h5")
    other = run(impacting(steps, begin, mesh={"degree": 8, "tol": 1e-10}), tmp_path / "b.h5")
    for name, step in (("tau_d", "tau"), ("K", "K")):
        fine, coarse = grazing_rows(results.step(step), name), grazing_rows(other.step(step), name)
        assert fine == pytest.approx(coarse, abs=1e-9)
        assert len(fine) == (2 if name == "tau_d" else 1)
    assert grazing_rows(results.step("tau"), "tau_d") == pytest.approx([3.2164416411, 4.6951888028], abs=2e-9)


def test_grazings_of_the_free_orbit_are_those_of_the_closed_form(tmp_path):
    begin = start("100*2*pi/omega", initial={"x": 0, "v": -1})
    text = impacting([("tau", {"tau_d": [3, 8]}, {})], begin, changes={"tau_d": 5.5})
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
    numeric = numeric_from(
        "name: m\nstates: [x, v]\nparameters: {K: 0.12, tau: 4.7007576118}\nforcing: {period: 2*pi/0.8}\n"
        "modes: {m: {x': v, v': 0.576*sin(0.8*t) - 0.02*v - x + K*(v(t - tau) - v)}}\n"
    )
    mesh = Mesh(8, 1, segment_pieces(1, 2, equal_cuts([16])))
    signature, top = Signature(numeric, (make_eventless(numeric.model, "m"),)), parse_monitor(numeric, "top", "max(x)")
    errors = []

    def closed(n):
        return brentq(
            lambda tau: grazing_amplitude(0.12, chain_transfer(0.8, tau, order, n)) - 1.26, 4.2, 5.1, xtol=1e-13
        )

    for n in steps:

        def miss(tau, n=n):
            problem = OrbitProblem(signature, mesh, Chain(order, n), np.array([0.12, tau]))
            guess = problem.unknowns.join(np.zeros((mesh.n_base, 2)), [2 * math.pi / 0.8], 0.0, [])
            return top.evaluate(solve_orbit(Orbit(problem, guess), MeshRule(8, intervals=16)).at.orbit) - 1.26

        found = brentq(miss, 4.2, 5.1, xtol=1e-12)
        assert found == pytest.approx(closed(n), abs=1e-9)
        errors.append(abs(found - GRAZING_TAU[0]))
    # These lengths are not yet where the order has settled for every M; the closed form says what it is here and at the
    # limit.
    measured, expected = (math.log2(e[0] / e[1]) for e in (errors, [abs(closed(n) - GRAZING_TAU[0]) for n in steps]))
    assert measured == pytest.approx(expected, abs=0.01)
    limit = math.log2((closed(400) - GRAZING_TAU[0]) / (closed(800) - GRAZING_TAU[0])) if order < 3 else None
    assert (limit or measured) == pytest.approx(order, abs=0.6 if order == 4 else 0.1)


@pytest.mark.slow
def test_the_impacting_orbit_through_every_crossing_of_breaking_points(tmp_path):
    text = {
        "model": "impact_oscillator",
        "set": {"K": 0.01},
        "mesh": {"degree": 5, "tol": 1e-06},
        "steps": [
            {"name": "t", "simulate": {"t_end": "120*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {"from": "o", "free": ["tau_d"], "range": {"tau_d": [0.01, 20]}, "max_points": 2000},
            },
        ],
    }
    results = run(text, tmp_path / "a.h5")
    step = results.step("c")
    assert [t.split(":")[1].strip().split(";")[0] for t in describe_endings(step)] == [
        f"reached the end of the range, tau_d = {end}" for end in (0.01, 20)
    ]
    # The mesh keeps what each interval adds below the tolerance; all of them together may be a little more.
    assert np.max(step.points["error_estimate"]) <= 2e-6
    assert np.all(step.points["admissible"] == 1)
    taus = step.points["parameters"][step.order, -1]
    assert (taus[0], taus[-1]) == pytest.approx((0.01, 20))
    # Points of the branch are those of the orbit computed plainly on a fine mesh of its own.
    for i in step.order[:: len(step) // 6]:
        again = {
            "model": "impact_oscillator",
            "mesh": {"degree": 9, "tol": 1e-10},
            "monitors": {"v": "at(NC, v)"},
            "steps": [{"name": "o", "orbit": {"from": {"file": str(tmp_path / "a.h5"), "step": "c", "index": int(i)}}}],
        }
        plain = run(again, tmp_path / "b.h5").step("o")
        fine = plain.points["monitors"][0, 0]
        coarse = step.orbit(i)["states"][np.flatnonzero(step.orbit(i)["segment"] == 0)[-1], 1]
        assert coarse == pytest.approx(fine, abs=10 * step.points["error_estimate"][i])


def test_the_free_orbit_over_the_whole_range_of_delays(tmp_path):
    """Without the wall, so admissible or not: the amplitude is that of the closed form at every delay."""
    text = {
        "model": "impact_oscillator",
        "mesh": {"degree": 10, "tol": 1e-11},
        "effects": {"off": ["impact"]},
        "monitors": {"top": "max(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "60*2*pi/omega"}, "set": {"tau_d": 3.8}},
            {"name": "o", "set": {"tau_d": 3.8}, "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["tau_d"], "range": {"tau_d": [0.01, 20]}}},
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    taus = step.points["parameters"][step.order, -1]
    assert (taus[0], taus[-1]) == pytest.approx((0.01, 20))
    exact = [grazing_amplitude(0.12, np.exp(-0.8j * tau)) for tau in taus]
    assert step.points["monitors"][step.order, 0] == pytest.approx(exact, abs=1e-9)


def test_grazing_in_the_gain_against_the_closed_form(tmp_path):
    """The free orbit followed down in K at tau_d = 3.8: it grazes at K = 0.1774776777."""
    text = {
        "model": "impact_oscillator",
        "set": {"K": 0.3},
        "mesh": {"degree": 10, "tol": 1e-11},
        "steps": [
            {"name": "t", "simulate": {"t_end": "60*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["K"], "range": {"K": [0.05, 0.5]}, "direction": "down"}},
        ],
    }
    assert grazing_rows(run(text, tmp_path / "a.h5").step("c"), "K") == pytest.approx([0.1774776777], abs=1e-9)
