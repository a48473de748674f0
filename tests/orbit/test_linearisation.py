"""Derivatives of single equations at an orbit, against differences in the unknowns that move times."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.orbit import Linearisation, Orbit
from pddecont.orbit.equations import FunctionEquations, list_equations
from pddecont.orbit.jacobian import PeriodicColumns
from tests.known_orbits import impact_oscillator
from tests.orbit.exact import circle

ORBITS = {
    "two segments": lambda: impact_oscillator().with_free(("tau_d", "K")),
    "circle": lambda: circle(free=("tau",)),
}


@pytest.fixture(params=ORBITS)
def found(request):
    orbit = ORBITS[request.param]()
    columns = PeriodicColumns(orbit.problem)
    return orbit, Linearisation(columns, orbit.problem.free_index, orbit, orbit.equation_reads)


def values_of(e, orbit):
    """Return a factor times a function at its points."""
    reads = orbit.equation_reads
    h = reads.h[orbit.mesh.equation_points.interval[e.points]]
    f = e.function.value(reads.t[e.points], reads.x[:, e.points], reads.xd[:, e.points], orbit.parameters)
    return (e.sign or -h) * f


def test_equations_move_with_durations(found):
    orbit, at = found
    for e in (e for e in list_equations(orbit.problem) if isinstance(e, FunctionEquations)):
        moves = at.moves(e)
        assert at.moves(e) is moves
        for s in range(orbit.mesh.n_segments):
            step = 1e-5 * np.eye(len(orbit.x))[orbit.problem.unknowns.duration(s)]
            ahead, behind = (values_of(e, Orbit(orbit.problem, orbit.x + d)) for d in (step, -step))
            assert moves[:, :, s] == pytest.approx((ahead - behind) / 2e-5, abs=1e-6)


def test_equations_move_with_delays_that_free_parameters_move(found):
    """Times the delays' own derivatives: what a parameter does through the delay alone."""
    orbit, at = found
    S = orbit.mesh.n_segments
    assert at.tau_derivatives == pytest.approx(np.eye(1, len(orbit.free)))
    step = 1e-5 * np.eye(len(orbit.x))[orbit.problem.unknowns.free.start]
    for e in (e for e in list_equations(orbit.problem) if isinstance(e, FunctionEquations)):
        ahead, behind = (values_of(e, Orbit(orbit.problem, orbit.x + d)) for d in (step, -step))
        own = np.zeros(ahead.shape)
        places = e.function.structure(at.free).dp
        for out, k, value in zip(*places, at.derivatives(e).dp, strict=True):
            if k == 0:
                own[out] += (at.factor(e) * np.ones(len(e.points))) * value
        total = own + at.moves(e)[:, :, S:] @ at.tau_derivatives[:, 0]
        assert total == pytest.approx((ahead - behind) / 2e-5, abs=1e-6)


def test_delayed_values_move_with_durations_and_delays(found):
    orbit, at = found
    free = orbit.problem.unknowns.free
    places = [orbit.problem.unknowns.duration(s) for s in range(orbit.mesh.n_segments)] + [free.start]
    assert at.tables.shape[2] == len(places)
    for k, place in enumerate(places):
        step = 1e-5 * np.eye(len(orbit.x))[place]
        ahead, behind = (Orbit(orbit.problem, orbit.x + d).equation_reads.xd for d in (step, -step))
        assert at.tables[:-1, :, k] == pytest.approx((ahead - behind) / 2e-5, abs=1e-6)


def test_what_is_needed_twice_is_found_once(found):
    orbit, at = found
    e = next(e for e in list_equations(orbit.problem) if isinstance(e, FunctionEquations))
    assert at.derivatives(e) is at.derivatives(e)
    assert at.factor(e) == pytest.approx(-at.h[e.points])
    assert np.all(at.factor(replace(e, sign=-1.0)) == -1.0)
