"""DOP853 has order 8, its extension order 7, also over events and delays."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import DOP853, solve_ivp

from pddecont.delay import Direct
from pddecont.simulate import Method, simulate
from tests.conftest import shipped
from tests.simulate.orders import FIXED, bouncer_errors, measure_order, oscillator_error


def test_the_coefficients_are_consistent(interpreted):
    m = interpreted.dop853
    assert np.sum(m.B) == pytest.approx(1.0)
    # Row 12 is the end of the step, which B makes.
    rows = [k for k in range(16) if k != 12]
    assert m.A[rows].sum(axis=1) == pytest.approx(m.C[rows], abs=1e-14)
    assert m.C[12] == 1.0
    assert np.allclose(np.triu(m.A), 0.0)
    # Quadrature of order 8.
    for k in range(1, 8):
        assert m.B @ m.C[:12] ** k == pytest.approx(1 / (k + 1))


def test_a_step_is_that_of_scipy(interpreted):
    text = (
        "name: m\nstates: [x, v]\nparameters: {p: 9}\nforcing: {period: p}\n"
        "modes: {m: {x': v, v': -sin(x) + cos(2*pi*t/p)}}\n"
    )
    run = interpreted.start(text, [0.3, 0.7], t=0.2)
    c, h = run.core, 0.4
    interpreted.rhs.evaluate_rhs(c, 0, 0.2, c.y, c.stages)
    error = interpreted.dop853.try_explicit_step(c, 0.2, h)
    interpreted.dop853.extend_explicit_step(c, 0.2, h)

    def field(t, y):
        return [y[1], -math.sin(y[0]) + math.cos(2 * math.pi * t / 9)]

    solver = DOP853(field, 0.2, [0.3, 0.7], 10.0, first_step=h, rtol=1e-3, atol=1e-3)
    solver.step()
    dense, y = solver.dense_output(), np.zeros(2)
    assert solver.t == pytest.approx(0.2 + h)
    assert c.trial[2:4] == pytest.approx(solver.y, rel=1e-14)
    for s in (0.1, 0.5, 0.8):
        interpreted.history.interpolate_state(c, s, y, 2)
        assert y == pytest.approx(dense(0.2 + s * h), rel=1e-13)
    assert 0.0 < error < math.inf


def test_the_defect_is_small_where_the_solution_is_smooth(interpreted):
    text = "name: m\nstates: [x]\nmodes: {m: {x': -x}}\n"
    run = interpreted.start(text, [1.0])
    defects = []
    for h in (0.4, 0.2, 0.1):
        run.core.y[0] = 1.0
        interpreted.rhs.evaluate_rhs(run.core, 0, 0.0, run.core.y, run.core.stages)
        interpreted.dop853.try_explicit_step(run.core, 0.0, h)
        interpreted.dop853.extend_explicit_step(run.core, 0.0, h)
        defects.append(interpreted.dop853.estimate_extension_error(run.core, 0.0, h))
    # h f - dy/ds of an extension of order 7 falls with h^8.
    assert np.log2(np.array(defects[:-1]) / defects[1:]) == pytest.approx(8.0, abs=0.5)


def test_order_without_events():
    h = [0.75, 0.6, 0.5, 0.4, 0.3]
    assert 7.7 < measure_order(h, [oscillator_error(Method(FIXED, FIXED), step) for step in h]) < 10.0


def test_order_with_events_and_a_delay():
    """Steps divide the time between bounces."""
    h = [math.pi / 2 / n for n in (4, 5, 6, 7, 8)]
    errors = [bouncer_errors(Method(FIXED, FIXED), step) for step in h]
    assert 7.3 < measure_order(h, [y for y, _ in errors]) < 8.7
    assert 7.3 < measure_order(h, [t for _, t in errors]) < 8.7


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-9])
def test_what_delays_read_is_as_good_as_the_ends_of_steps(rtol):
    """Mackey-Glass's cycle, n = 6.5, tau = 2: each step's extension against the exact solution from its start, with the
    past as it is.

    Without control of the extension's defect the largest error is 15 to 283 rtol.
    """
    numeric = shipped("mackey_glass")
    p = numeric.parameter_values.copy()
    p[numeric.parameter_index("n")], p[numeric.parameter_index("tau")] = 6.5, 2.0
    trajectory = simulate(numeric, p, Direct(), 40.0, Method(rtol, 0.01 * rtol))

    def field(t, x):
        delayed = trajectory(t - 2.0)[0]
        return [2.0 * delayed / (1.0 + delayed**6.5) - x[0]]

    worst = 0.0
    for i in np.flatnonzero((trajectory.time > 25.0) & (trajectory.end < 39.0)):
        start, end = trajectory.time[i], trajectory.end[i]
        # The past is smooth between its own steps.
        edges = [start, *(t + 2.0 for t in trajectory.time if start < t + 2.0 < end), end]
        x = trajectory.value[i]
        for a, b in itertools.pairwise(edges):
            exact = solve_ivp(
                field, (a, b), x, method="DOP853", rtol=1e-13, atol=1e-15, dense_output=True, max_step=(b - a) / 2
            )
            inside = np.linspace(a, b, 6)[1:]
            worst = max(
                worst,
                np.max(np.abs(exact.sol(inside)[0] - trajectory.evaluate_arc(int(trajectory.arc[i]), inside)[:, 0])),
            )
            x = exact.y[:, -1]
    assert 0.0 < worst < 4.0 * rtol
