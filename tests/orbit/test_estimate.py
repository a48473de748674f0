"""The recorded error estimate against true errors, for every model that has an orbit.

The true error is the distance to a solution of degree 12 on a mesh for 1e-12, which a second one of degree 10 must
confirm to a tenth of it; orbits that are closer to the truth than that are left out, since nothing is known of their
errors.
"""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import MeshRule, transfer
from pddecont.continuation import (
    BranchState,
    CurvePoint,
    NewtonSettings,
    StepSettings,
    TestFunctions,
    correct,
    find_tangent,
    follow_branch,
)
from pddecont.delay import Chain, Chebyshev, Direct
from pddecont.errors import ConvergenceError
from pddecont.orbit import (
    Orbit,
    PeriodicOrbitSystem,
    RangeBoundary,
    adapt_mesh,
    estimate_error,
    measure_orbit,
    measure_states,
    solve_on_mesh,
    solve_orbit,
)
from tests.conftest import MODELS as SHIPPED
from tests.orbits import settle_to_orbit

MESHES = [
    *(
        MeshRule(d, intervals=n)
        for d, n in [(2, 20), (3, 6), (3, 14), (4, 8), (4, 30), (5, 12), (6, 8), (6, 16), (7, 10), (8, 12)]
    ),
    *(MeshRule(d, tol=tol) for d, tol in [(4, 1e-3), (4, 1e-6), (6, 1e-4), (6, 1e-6), (6, 1e-8), (8, 1e-9)]),
]
CHAIN_MESHES = [
    MeshRule(d, intervals=n) for d, n in [(2, 16), (3, 8), (3, 16), (4, 12), (4, 24), (5, 10), (6, 8), (6, 16), (7, 12)]
]
LINES = [Chain(1, 40), Chain(2, 15), Chain(2, 1000), Chain(3, 8), Chebyshev(14)]

MODELS = {
    "impact_oscillator": 600,
    "impact_oscillator_autonomous": 800,
    "wall_oscillator": 300,
    "bouncing_ball": 1200,
    "den_hartog": 1500,
    "duffing": 400,
    "mackey_glass": 300,
    "on_off_control": 60,
    "pulsed_control": 300,
    "relay": 60,
    "spiking_neuron": 60,
    "van_der_pol": 120,
    "wright": 150,
    "act_and_wait": 45,
    "belt_stick_slip": 60,
    "bolus": 2400,
    "enso_relay": 120,
    "full_oscillator": 1600,
    "human_balance": 200,
    "interrupted_cutting": 800,
    "pulse_vaccination": 300,
    "rimless_wheel": 60,
    "turning": 3000,
    "two_stage_oscillator": 785,
    "boost_converter": 40,
    "buck_converter": 80,
    "dry_friction": 800,
    "friction_belt": 60,
    "gear_backlash": 2100,
    "harvested_predators": 2000,
    "impact_oscillator_max": 600,
    "relay_sliding": 300,
    "ring_of_cars": 300,
    "thermostat": 60,
    "two_blocks": 300,
}
# Falls over; needs a kick on the way; has no damping to settle by; the others rest.
WITHOUT_ORBIT = {
    "suitcase",
    "theta_neuron",
    "linear_oscillator",
    "two_neurons",
    "delayed_predator_prey",
    "duffing_feedback",
}
# They read rates, or more than states a constant time ago, and are measured in tests/models/test_smooth_orbits.py.
READ_OTHERWISE = {
    "transmission_line",
    "neutral_logistic",
    "distributed_maturation",
    "robot_arm",
    "remembering_drivers",
    "state_dependent_lag",
    "sawtooth",
    "two_state_dependent_lags",
    "varying_speed",
    "turning_tangential",
    "drill_string",
}
# A jump of the state comes back through the delay: without tracking it lies anywhere in an interval, and the estimate
# may not see it.
JUMPS_COME_BACK = {"bolus"}
RESOLVED = 10.0
# True errors and estimates below this are rounding.
ROUNDING = 1e-12


def distance(a, b, width=1.0):
    """Return how far orbit ``a`` is from ``b``, at equal fractions of each segment.

    States count relative to their sizes, times to the period, a free parameter to the ``width`` of its range.
    """
    b = in_phase(b, a)
    dense = replace(a.mesh, degree=3 * a.mesh.degree)
    here = transfer(a.mesh, a.theta, a.values, dense, a.theta)
    there = transfer(b.mesh, b.theta, b.values, dense, a.theta)
    times = np.append(a.durations - b.durations, a.start - b.start)
    return max(
        np.max(np.abs(here - there) / measure_states(a.values)),
        np.max(np.abs(times)) / a.period,
        np.max(np.abs(a.free - b.free), initial=0.0) / width,
    )


def in_phase(other, orbit):
    """Return the ``other`` orbit in the phase that the reference of ``orbit`` fixes, for orbits that have one."""
    if orbit.problem.reference is None:
        return other
    mesh = orbit.mesh
    reference = transfer(mesh, mesh.reference_theta, orbit.problem.reference, other.mesh, other.theta)
    same = Orbit(replace(other.problem, reference=reference), other.x).with_free(())
    return solve_on_mesh(same).at.orbit.with_free(other.problem.free)


def solved_on(orbit, rule):
    """Return the solution on a mesh of ``rule``, or None where so coarse a mesh has none."""
    try:
        return solve_orbit(adapt_mesh(orbit, rule), rule)
    except ConvergenceError:
        return None


def on(orbit, rule):
    """Return the orbit on a mesh of ``rule``, or None where so coarse a mesh has none."""
    solution = solved_on(orbit, rule)
    return None if solution is None else solution.at.orbit


def with_delay(orbit, delay):
    """Return the orbit as a guess of that with another way to discretise its delays."""
    return Orbit(replace(orbit.problem, delay=delay), orbit.x)


def measured(solutions, exact, check):
    """Return true errors and estimates of orbits for which the truth is known well enough."""
    pairs = [
        (distance(s.at.orbit, exact), distance(s.at.orbit, check), estimate_error(s.at.orbit, (), s.solve))
        for s in solutions
        if s
    ]
    known = [(true, estimate) for true, other, estimate in pairs if abs(true - other) < true / RESOLVED]
    # An orbit that the mesh holds to rounding has no error left to be estimated: where both its true error and the
    # estimate are that small, their ratio is one of rounding errors and says nothing.
    known = [(true, estimate) for true, estimate in known if max(true, estimate) >= ROUNDING]
    return np.array(known).reshape(-1, 2).T


def trusted(errors, estimates):
    """Assert the promise: within a factor of 10 in 95 of 100 cases, never below a hundredth of the error."""
    ratio = errors / estimates
    assert np.mean((ratio < 10) & (ratio > 0.1)) >= 0.95, ratio
    assert np.max(ratio) < 100, ratio


def test_every_model_is_here():
    assert {path.stem for path in SHIPPED} == MODELS.keys() | WITHOUT_ORBIT | READ_OTHERWISE


@pytest.mark.parametrize("model", MODELS)
def test_delays_read_directly(model, compare):
    check = settle_to_orbit(model, t_end=MODELS[model])
    exact = on(check, MeshRule(12, tol=1e-12))
    tracked = [True, False] if check.numeric.model.delays and model not in JUMPS_COME_BACK else [True]
    found = [solved_on(with_delay(check, Direct(track)), rule) for rule in MESHES for track in tracked]
    errors, estimates = measured(found, exact, check)
    # Of a smooth orbit most meshes leave nothing but rounding.
    assert len(errors) >= min(12, 0.6 * len(found))
    compare(model, errors, estimates)
    trusted(errors, estimates)


@pytest.mark.parametrize(
    "model",
    [
        "impact_oscillator",
        "impact_oscillator_autonomous",
        "mackey_glass",
        "on_off_control",
        "pulsed_control",
        "relay",
        "van_der_pol",
        "wright",
        "human_balance",
        "two_stage_oscillator",
    ],
)
def test_delay_lines(model, compare):
    """The error of the collocated line against the same line on a fine mesh, not against the delay equation."""
    orbit = settle_to_orbit(model, t_end=MODELS[model], mesh={"degree": 8, "tol": 1e-8})
    all_errors, all_estimates = [], []
    for line in LINES:
        start = on(with_delay(orbit, line), MeshRule(6, intervals=30))
        if start is None:
            continue
        exact, check = (on(start, MeshRule(d, intervals=n)) for d, n in ((9, 50), (8, 40)))
        found = [solved_on(start, rule) for rule in CHAIN_MESHES]
        errors, estimates = measured(found, exact, check)
        all_errors += [*errors]
        all_estimates += [*estimates]
    assert len(all_errors) >= 0.6 * len(LINES) * len(CHAIN_MESHES)
    compare(f"{model}, delay lines", all_errors, all_estimates)
    trusted(np.array(all_errors), np.array(all_estimates))


BRANCHES = [
    ("duffing", "omega", (0.8, 2.6), MeshRule(5, intervals=16)),
    ("mackey_glass", "tau", (0.6, 1.6), MeshRule(5, intervals=14)),
    ("impact_oscillator", "K", (0.02, 0.17), MeshRule(5, intervals=16)),
    ("relay", "a", (0.0, 0.6), MeshRule(4, intervals=8)),
    ("bouncing_ball", "G", (0.36, 1.2), MeshRule(4, intervals=5)),
]


@pytest.mark.parametrize(("model", "name", "ends", "rule"), BRANCHES, ids=lambda v: v if isinstance(v, str) else "")
def test_along_branches_and_round_folds(model, name, ends, rule, compare):
    """Every point against the nearest exact orbit, its parameter included: at a fold no exact orbit need have the same
    parameter.
    """
    orbit = on(settle_to_orbit(model, t_end=MODELS[model]), rule).with_free((name,))
    width = ends[1] - ends[0]
    system = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, (width,)), rule)
    at, towards = system.at(orbit.x), np.zeros(len(orbit.x))
    towards[-1] = 1.0
    direction = find_tangent(at, system.scaling, towards)
    points = []
    for sign in (1, -1):
        start = BranchState(CurvePoint(system, at, None, sign * direction), 0.0, 0.02, 1)
        settings = StepSettings(max_points=60)
        follow_branch(
            start, [RangeBoundary(orbit.problem.free, (ends,))], TestFunctions(), settings, points.append, sign
        )
    assert len(points) > 12
    errors, estimates = [], []
    for point in points:
        here = point.state.point.at.orbit
        nearest = [_nearest(point.state, fine) for fine in (MeshRule(12, tol=1e-12), MeshRule(10, tol=1e-11))]
        true, other = (distance(here, exact, width) for exact in nearest)
        if abs(true - other) < true / RESOLVED:
            errors.append(true)
            estimates.append(estimate_error(here, (width,), point.state.point.solve_nearly))
    assert len(errors) >= len(points) - 2
    compare(f"{model}, along a branch", errors, estimates)
    trusted(np.array(errors), np.array(estimates))


def _nearest(state, rule):
    """Return the exact orbit in the hyperplane across the branch at ``state``."""
    system = PeriodicOrbitSystem(state.point.system.problem, state.point.system.sizes, rule)
    fine, x, (along,) = system.remesh(system.at(state.x), [state.x + 1e-3 * state.tangent], solved=True)
    for _ in range(3):
        solution = correct(fine, x, fine.scaling.normalise(along - x), NewtonSettings())
        if fine.mesh_is_adequate(solution.at):
            break
        fine, x, (along,) = fine.remesh(solution.at, [along], solved=True)
    return solution.at.orbit
