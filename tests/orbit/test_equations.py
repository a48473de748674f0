"""The list of equations: every row is there, what kinds there are, and that the residual is made of the same."""

import numpy as np
import pytest

from pddecont.orbit.equations import (
    DelayedEventEquation,
    FunctionEquations,
    PeriodEquation,
    PhaseEquation,
    SlopeEquations,
    StateAfter,
    list_equations,
)
from pddecont.orbit.residual import Rows, compute_residual
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass, neuron
from tests.orbit.exact import circle

ORBITS = [impact_oscillator, hard_wall, mackey_glass, neuron, circle]


def rows_of(equation):
    match equation:
        case SlopeEquations() | FunctionEquations() | StateAfter():
            return np.ravel(equation.rows)
        case _:
            return np.array([equation.row])


@pytest.mark.parametrize("make", ORBITS, ids=lambda f: f.__name__)
def test_every_row_has_an_equation(make):
    problem = make().problem
    rows, equations = Rows(problem.unknowns), list(list_equations(problem))
    # An autonomous model's last equation has a row just beyond the others, and no entries.
    own = [e for e in equations if not isinstance(e, PeriodEquation) or problem.numeric.model.forced]
    assert set(np.concatenate([rows_of(e) for e in own]).tolist()) == set(range(rows.size))
    # The slopes' rows are those of the vector fields, the resets' those of the states after.
    fields = [e for e in equations if isinstance(e, FunctionEquations) and e.sign == 0.0]
    (slopes,) = (e for e in equations if isinstance(e, SlopeEquations))
    assert sorted(np.concatenate([np.ravel(e.rows) for e in fields])) == sorted(np.ravel(slopes.rows))


@pytest.mark.parametrize("make", ORBITS, ids=lambda f: f.__name__)
def test_the_residual_is_the_sum_of_them(make):
    """Functions times their factors, slopes and states after: put together from the list for any unknowns."""
    orbit = make()
    problem, mesh = orbit.problem, orbit.mesh
    reads, rows = orbit.equation_reads, Rows(problem.unknowns)
    total = np.zeros(rows.events + mesh.n_segments)
    others = set()
    for e in list_equations(problem):
        match e:
            case SlopeEquations():
                local = np.matmul(mesh.basis.slopes, orbit.values[mesh.base_index])
                total[e.rows] += local
            case StateAfter():
                total[e.rows] += orbit.values[mesh.first_base[(e.segment + 1) % mesh.n_segments]]
            case FunctionEquations():
                x = np.einsum("pb,pbn->np", e.weights, orbit.values[e.base])
                assert x == pytest.approx(reads.x[:, e.points], abs=1e-11)
                f = e.function.value(reads.t[e.points], x, reads.xd[:, e.points], orbit.parameters)
                h = reads.h[mesh.equation_points.interval[e.points]]
                total[e.rows] += (e.sign or -h) * f
            case _:
                others.add(e.row)
    exact = compute_residual(orbit)[: len(total)]
    kept = [k for k in range(len(total)) if k not in others]
    assert total[kept] == pytest.approx(exact[kept], abs=1e-11)


def test_what_fixes_the_phase():
    kinds = {make.__name__: [type(e) for e in list_equations(make().problem)] for make in ORBITS}
    assert PhaseEquation in kinds["mackey_glass"]
    assert PhaseEquation in kinds["circle"]
    assert PhaseEquation not in kinds["impact_oscillator"]
    assert DelayedEventEquation in kinds["neuron"]
    assert DelayedEventEquation not in kinds["hard_wall"]
    assert all(found[-1] is PeriodEquation for found in kinds.values())
