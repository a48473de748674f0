"""Rows of a basin: cells go to known attractors, and strays are followed."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import (
    BasinRow,
    InitialState,
    Method,
    MotionTask,
    ReturnSection,
    ReturnSettings,
    classify_row,
    survey_attractors,
)
from tests.conftest import numeric_from

# Wells at x = -1 and 1; y follows the forcing.
WELLS = (
    "name: wells\nstates: [x, y]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\n"
    "modes: {m: {x': x - x**3, y': cos(w*t) - y}}\n"
)
SETTINGS = ReturnSettings(2 * np.pi, 0.0, 200.0, 4, 20)
START = InitialState(np.array([0.0, 0.3]), "m", True)


@pytest.fixture
def task():
    return MotionTask(numeric_from(WELLS), Direct(), Method(), ReturnSection())


def states(*xs):
    return np.array([[x, 0.3] for x in xs])


def test_a_survey_finds_each_attractor_once_in_its_order(task):
    found = survey_attractors(task, np.array([1.0]), SETTINGS, states(0.5, 2.0, -0.1, -3.0, 0.01), START)
    assert [a.states[0, 0] for a in found] == pytest.approx([1.0, -1.0], abs=1e-6)
    assert all(a.period == 1 and a.failure is None for a in found)


def test_cells_get_the_numbers_of_the_known(task):
    known = tuple(survey_attractors(task, np.array([1.0]), SETTINGS, states(0.5, -0.5), START))
    row = classify_row(task, BasinRow(np.array([1.0]), SETTINGS, states(-2, -0.1, 0.1, 2), START, known))
    assert list(row.labels) == [1, 1, 0, 0]
    assert row.strays == {}
    assert np.all(row.times > 2 * np.pi)


def test_a_stray_is_followed_until_it_settles(task):
    known = tuple(survey_attractors(task, np.array([1.0]), SETTINGS, states(0.5), START))
    row = classify_row(task, BasinRow(np.array([1.0]), SETTINGS, states(-2, 2), START, known))
    assert list(row.labels) == [-1, 0]
    assert list(row.strays) == [0]
    assert row.strays[0].states[0] == pytest.approx([-1.0, 0.5], abs=1e-6)


def test_a_row_where_nothing_is_known_has_strays_only(task):
    row = classify_row(task, BasinRow(np.array([1.0]), SETTINGS, states(-2, 2), START, ()))
    assert list(row.labels) == [-1, -1]
    assert sorted(row.strays) == [0, 1]
