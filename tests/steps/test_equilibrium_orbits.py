"""From Hopf points to the orbits that are born there, and back: sizes and places against calculations of their own."""

import numpy as np
import pytest

from pddecont.orbit.serialise import mesh_from_row
from tests.equilibrium import harmonic_balance
from tests.equilibrium.hopf_models import ALL
from tests.runs import labels, parameter, run

# Half of the range in which orbits are followed, as a part of the range in which the equilibrium is.
NEAR = 0.02


@pytest.fixture(scope="module", params=ALL)
def born(request, tmp_path_factory):
    """Return an independent Hopf point and the results of a run: equilibria, their orbits, and back to the point."""
    made = ALL[request.param]
    birth = harmonic_balance.find_birth(made.field, made.states, made.frequency, made.near)
    low, high = made.range_
    near = [birth.parameter - NEAR * (high - low), birth.parameter + NEAR * (high - low)]
    rest = dict(zip(made.model["states"], made.states, strict=True))
    follow = {"free": [made.free], "range": {made.free: near}}
    steps = [
        {"name": "rest", "set": {made.free: made.start}, "equilibrium": {"from": rest}},
        {"name": "along", "continue": {"from": "rest", "free": [made.free], "range": {made.free: [low, high]}}},
        {"name": "orbits", "continue": {"from": {"step": "along", "point": "HB1"}, "branch": "switch", **follow}},
        {
            "name": "back",
            "continue": {
                "from": {"step": "orbits", "point": "EP1"},
                "direction": "down" if birth.growth > 0 else "up",
                **follow,
            },
        },
    ]
    path = tmp_path_factory.mktemp(request.param) / "r.h5"
    return birth, made, run({**made.model, "run": {"mesh": {"degree": 7, "tol": 1e-10}, "steps": steps}}, path)


def measure_amplitude(step, i, q):
    """Return |conj(q) . X_1| of an orbit, X_1 its first harmonic."""
    row = step.orbit(int(i))
    mesh, period = mesh_from_row(row["mesh"]), float(step.points["period"][i])
    theta = np.zeros(mesh.length.shape[1])
    theta[0] = period
    points = mesh.grid(mesh.basis.nodes)
    weights = np.outer(mesh.length @ theta, mesh.basis.weights).ravel() / period
    states, times = mesh.interpolate(row["states"], points), mesh.times(points) @ theta
    return abs(np.vdot(q, (weights * np.exp(-2j * np.pi * times / period)) @ (states - weights @ states)))


def test_the_hopf_point_and_its_coefficient_are_those_of_an_independent_calculation(born):
    birth, made, results = born
    step = results.step("along")
    row = step.row("HB1")
    assert parameter(step, made.free, "HB1") == pytest.approx(birth.parameter, abs=1e-12)
    assert step.points["frequency"][row] == pytest.approx(birth.frequency, rel=1e-12)
    assert step.points["coefficient"][row] == pytest.approx(birth.cubic.real / birth.frequency, rel=1e-10)
    assert step.reason(row).values["nature"] == ("supercritical" if birth.cubic.real < 0 else "subcritical")
    assert step.reason(row).values["side"] == ("larger" if birth.growth > 0 else "smaller")


def test_the_square_of_the_amplitude_grows_as_the_normal_form_says(born):
    """A parabola through |z|^2 / (p - p_0) of the orbits nearest the point, at the point itself."""
    birth, made, results = born
    step = results.step("orbits")
    away = parameter(step, made.free)[:6] - birth.parameter
    squared = np.array([measure_amplitude(step, i, np.array(birth.vector)) ** 2 for i in step.order[:6]])
    slopes = np.polynomial.polynomial.polyfit(away, squared / away, 2)
    assert slopes[0] == pytest.approx(birth.growth, rel=1e-6)
    # Nearest to the point they differ from it by less than the range that is left out.
    assert np.all(np.abs(squared / away / birth.growth - 1) < 0.02)


def test_orbits_that_shrink_end_in_the_same_hopf_point(born):
    birth, made, results = born
    step = results.step("back")
    assert labels(step) == ["HB1"]
    row = step.row("HB1")
    assert parameter(step, made.free, "HB1") == pytest.approx(birth.parameter, abs=1e-11)
    assert 2 * np.pi / step.points["period"][row] == pytest.approx(birth.frequency, rel=1e-11)
