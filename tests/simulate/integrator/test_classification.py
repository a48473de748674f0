"""Cells of a grid go to the attractor whose returns they come to."""

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.simulate import Simulator
from pddecont.simulate.integrator import KnownReturns, classify_cells
from tests.conftest import numeric_from

WELLS = (
    "name: wells\nstates: [x, y]\nparameters: {w: 1, tau: 0.5}\nforcing: {period: 2*pi/w}\n"
    "modes: {m: {x': x - x(t - tau)*x**2, y': cos(w*t) - y}}\n"
)


def classify(points, owner, following, length, initial, delay, transient=200.0):
    """Return labels and times of cells, with the history of each its own state."""
    numeric = numeric_from(WELLS)
    simulator = Simulator(numeric, delay)
    values = simulator.values(numeric.parameter_values)
    template = simulator.start(values, [0.0, 0.0], constant=True).y
    labels, times = np.full(len(initial), -7), np.zeros(len(initial))
    integers = [np.array(a, dtype=np.int64) for a in (owner, following, length)]
    known = KnownReturns(np.array(points, dtype=float).reshape(-1, 2), np.ones((len(points), 2)), *integers)
    classify_cells(
        simulator.system,
        values,
        simulator.work,
        template,
        np.array(initial),
        np.zeros(len(initial), dtype=np.int64),
        1,
        2 * np.pi,
        0.0,
        transient,
        known,
        labels,
        times,
    )
    return labels, times


@pytest.mark.parametrize("delay", [Direct(), Chain(2, 3)])
def test_each_cell_gets_the_number_of_its_attractor(delay):
    labels, times = classify(
        [[1, 0.5], [-1, 0.5]], [4, 9], [0, 1], [1, 1], [[0.3, 0], [-0.2, 2], [2, -1], [-0.01, 0]], delay
    )
    assert list(labels) == [4, 9, 4, 9]
    assert np.all((times > 0) & (times < 200))
    # A return is at a multiple of the period, and it takes two of them to be sure.
    assert times / (2 * np.pi) == pytest.approx(np.round(times / (2 * np.pi)))
    assert np.min(times) >= 2 * 2 * np.pi


def test_what_is_not_known_is_not_named():
    labels, times = classify([[1, 0.5]], [0], [0], [1], [[0.3, 0], [-0.2, 0]], Direct(), 60.0)
    assert list(labels) == [0, -1]
    assert times[1] == pytest.approx(60.0)


def test_returns_have_to_come_in_their_order():
    """An attractor of two returns, both at the well: each motion is at one of them, never at the other next."""
    labels, _ = classify([[1, 0.5], [3, 3]], [0, 0], [1, 0], [2, 2], [[0.3, 0]], Direct())
    assert list(labels) == [-1]
