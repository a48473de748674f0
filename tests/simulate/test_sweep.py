"""Chunks of a sweep: attractors with their shares, anew at each point or carried along."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import (
    FailureReason,
    InitialState,
    Method,
    MotionTask,
    ParameterPoint,
    ReturnSection,
    ReturnSettings,
    SweepChunk,
    sweep_chunk,
)
from tests.conftest import numeric_from
from tests.simulate.motions import BALL

# Wells at +-sqrt(a); where b grows the lower one is lost at b = 2 (a/3)^(3/2).
WELLS = (
    "name: wells\nstates: [x]\nparameters: {a: 1, b: 0}\nforcing: {period: 2*pi}\nmodes: {m: {x': a*x - x**3 + b}}\n"
)


def points(values, starts, settings=None):
    settings = settings or ReturnSettings(2 * np.pi, 0.0, 400.0, 4, 20)
    starts = tuple(InitialState(np.array([x]), "m", True) for x in starts)
    return tuple(ParameterPoint(k, np.array([1.0, b]), settings, starts) for k, b in enumerate(values))


def task_of(text, **method):
    return MotionTask(numeric_from(text), Direct(), Method(**method), ReturnSection())


def test_each_point_has_its_attractors_with_their_shares():
    found = sweep_chunk(task_of(WELLS), SweepChunk(points([0.0, 0.5], [-2, -1, 2]), False, False))
    assert [f.point.index for f in found] == [0, 0, 1]
    assert [f.share for f in found] == [pytest.approx(2 / 3), pytest.approx(1 / 3), 1.0]
    assert [f.attractor.states[0, 0] for f in found[:2]] == pytest.approx([-1, 1], abs=1e-6)
    assert np.isnan(found[0].exponent.value)


def test_a_motion_carried_along_stays_in_its_well_until_that_is_lost():
    values = [0.0, 0.2, 0.35, 0.45, 0.2, 0.0]
    carried = sweep_chunk(task_of(WELLS), SweepChunk(points(values, [-1]), True, False))
    x = [f.attractor.states[0, 0] for f in carried]
    assert [v > 0 for v in x] == [False, False, False, True, True, True]
    for v, b in zip(x, values, strict=True):
        assert v - v**3 + b == pytest.approx(0.0, abs=1e-5)


def test_exponents_are_those_of_the_wells():
    found = sweep_chunk(task_of(WELLS), SweepChunk(points([0.0], [-1, 2]), False, True))
    assert [f.exponent.value for f in found] == pytest.approx([-2.0, -2.0], abs=1e-4)


def test_a_motion_that_halted_starts_anew_at_the_next_point():
    task = MotionTask(numeric_from(BALL), Direct(), Method(), ReturnSection(event="hit"))
    start = InitialState(np.array([1.0, 0.0]), "fly", True)
    settings = ReturnSettings(0.0, 0.0, 50.0, 2, 9)
    chunk = SweepChunk(
        tuple(ParameterPoint(k, np.array([g, 0.8]), settings, (start,)) for k, g in enumerate([5.0, 10.0])), True, False
    )
    found = sweep_chunk(task, chunk)
    rest = [np.sqrt(2 / g) * 9 for g in (5.0, 10.0)]
    assert [f.attractor.failure.reason for f in found] == [FailureReason.ACCUMULATION] * 2
    assert [f.attractor.failure.time for f in found] == pytest.approx(rest, rel=1e-8)


def test_a_chunk_gives_the_same_numbers_whoever_computes_it():
    chunk = SweepChunk(points([0.1, 0.2, 0.3], [-1, 2]), True, True)
    one, other = sweep_chunk(task_of(WELLS), chunk), sweep_chunk(task_of(WELLS), chunk)
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a.attractor.packed_state, b.attractor.packed_state)
        assert a.exponent == b.exponent
