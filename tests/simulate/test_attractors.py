"""Attractors: told apart by their returns, found by where motions settle, failed for a reason."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pddecont.delay import Direct
from pddecont.simulate import (
    Attractor,
    FailureReason,
    Method,
    MotionFailure,
    ReturnSection,
    ReturnSettings,
    Simulator,
    find_attractor,
    find_or_add,
    group_attractors,
    has_left_section,
    is_same_attractor,
)
from pddecont.simulate import attractors as module
from pddecont.simulate.attractors import cover_same_region, is_stationary
from tests.conftest import numeric_from
from tests.simulate.motions import BALL, RELAY


def attractor(states, failure=None, period=None, turn=None, counts=(1,), slopes=None):
    states = np.array(states, dtype=float).reshape(-1, 1)
    slopes = np.zeros_like(states) if slopes is None else np.array(slopes, dtype=float).reshape(-1, 1)
    period = len(states) if period is None else period
    turn = float(period) if turn is None else turn
    times = np.arange(len(states), dtype=float)
    return Attractor(period, turn, states, slopes, times, np.array(counts), np.zeros(0), np.zeros(0), failure)


SAME = {"atol": 1e-11, "at_section": False}
numbers = st.lists(st.integers(0, 9), min_size=1, max_size=4)


@given(numbers, st.integers(0, 3))
def test_the_first_return_does_not_matter(states, shift):
    assert is_same_attractor(attractor(states), attractor(np.roll(states, shift)), **SAME)


@given(st.lists(numbers, min_size=1, max_size=8))
def test_groups_hold_each_attractor_once_with_its_share(motions):
    attractors = [attractor(states) for states in motions]
    groups = group_attractors(attractors, **SAME)
    assert sum(share for _, share in groups) == pytest.approx(1.0)
    for (a, _), (b, _) in itertools.combinations(groups, 2):
        assert not is_same_attractor(a, b, **SAME)
    for a in attractors:
        assert sum(is_same_attractor(a, b, **SAME) for b, _ in groups) == 1
    # The order is that in which they come first.
    firsts = [next(i for i, a in enumerate(attractors) if is_same_attractor(a, b, **SAME)) for b, _ in groups]
    assert firsts == sorted(firsts)


def test_a_known_attractor_keeps_its_number_and_a_new_one_gets_the_next():
    known = [attractor([1]), attractor([2, 3])]
    assert find_or_add(attractor([3, 2]), known, **SAME) == 1
    assert find_or_add(attractor([4]), known, **SAME) == 2
    assert find_or_add(attractor([4.001]), known, **SAME) == 2
    assert len(known) == 3


@pytest.mark.parametrize(
    ("a", "b", "same"),
    [
        (attractor([1, 2]), attractor([1, 2], turn=2.01), False),
        (attractor([1, 2]), attractor([1, 2], turn=2.001), True),
        (attractor([1, 2]), attractor([1, 2], counts=(2,)), False),
        (attractor([1, 2]), attractor([1, 2.01]), False),
        (attractor([1, 2], period=0), attractor([2, 1], period=0), True),
        (attractor([1, 2], period=0), attractor([1, 4], period=0), False),
        (attractor([1, 2], period=0), attractor([1, 2]), False),
    ],
)
def test_periods_times_counts_and_states_are_compared(a, b, same):
    assert is_same_attractor(a, b, **SAME) is same
    assert is_same_attractor(b, a, **SAME) is same


def test_at_a_section_slopes_are_compared_too():
    a, b = attractor([1], slopes=[1]), attractor([1], slopes=[2])
    assert is_same_attractor(a, b, atol=1e-11, at_section=False)
    assert not is_same_attractor(a, b, atol=1e-11, at_section=True)


ZENO = MotionFailure(FailureReason.ACCUMULATION, 3.0, "hit", "fly")


@pytest.mark.parametrize(
    ("failure", "same"),
    [
        (MotionFailure(FailureReason.ACCUMULATION, 4.5, "hit", "lie"), True),
        (MotionFailure(FailureReason.ACCUMULATION, 3.0, "stop", "fly"), False),
        (MotionFailure(FailureReason.SLIDING, 3.0, "hit", "fly"), False),
        (None, False),
    ],
)
def test_motions_that_fail_alike_are_one(failure, same):
    assert is_same_attractor(attractor([1], ZENO, 0), attractor([7], failure, 0), **SAME) is same


def test_a_size_is_of_states_or_of_how_far_slopes_take_them():
    assert attractor([1, -3]).size == pytest.approx([3.0])
    found = attractor([0.0], turn=2 * np.pi, slopes=[5.0])
    assert found.size == pytest.approx([5.0])


CIRCLE = (
    "name: m\nstates: [x, v]\nparameters: {c: 0.1}\n"
    "modes: {m: {x': v - c*x*(x**2 + v**2 - 1), v': -x - c*v*(x**2 + v**2 - 1)}}\ninitial: {x: 2}\n"
)


def find(text, settings, section=None, p=None, **method):
    numeric = numeric_from(text)
    simulator = Simulator(numeric, Direct(), Method(**method), section or ReturnSection())
    values = simulator.values(numeric.parameter_values if p is None else np.array(p))
    return find_attractor(simulator, values, simulator.start(values), settings)


def test_a_cycle_is_found_at_its_section():
    section = ReturnSection(expr=numeric_from(CIRCLE).model.state_symbols[0])
    found = find(CIRCLE, ReturnSettings(0.0, 0.0, 400.0, 4, 20), section)
    assert (found.period, found.failure) == (1, None)
    assert found.turn == pytest.approx(2 * np.pi, abs=1e-7)
    assert found.states[0] == pytest.approx([0.0, 1.0], abs=1e-6)
    assert found.slopes[0] == pytest.approx([1.0, 0.0], abs=1e-6)


DECAY = CIRCLE.replace("(x**2 + v**2 - 1)", "1")


@pytest.mark.parametrize(
    ("text", "level", "c", "transient", "reason"),
    [
        (CIRCLE, 0.0, 0.1, 5.0, FailureReason.NO_RETURN),
        (CIRCLE, 1.1, 0.001, 2000.0, FailureReason.SECTION_LEFT),  # it is at x = 2 first, and at x <= 1 later
        (DECAY, 0.0, 0.01, 60.0, FailureReason.NOT_SETTLED),
        (DECAY, 0.0, 0.02, 1500.0, FailureReason.EQUILIBRIUM),
    ],
)
def test_what_leads_to_no_attractor_has_a_reason(text, level, c, transient, reason):
    section = ReturnSection(expr=numeric_from(text).model.state_symbols[0] - level)
    found = find(text, ReturnSettings(0.0, 0.0, transient, 4, 20), section, p=[c])
    assert found.failure.reason == reason
    assert not found.failure.reason.halts
    assert found.period == 0


def test_a_motion_whose_past_has_too_many_steps_is_given_up(monkeypatch):
    text = (
        "name: w\nstates: [x]\nparameters: {tau: 50}\nforcing: {period: 2*pi/9}\n"
        "modes: {m: {x': -x(t - tau) + sin(9*t)}}\ninitial: {x: 1}\n"
    )
    section = ReturnSection(expr=numeric_from(text).model.state_symbols[0])
    settings = ReturnSettings(0.0, 0.0, 200.0, 4, 20)
    assert find(text, settings, section).failure.reason != FailureReason.PAST_TOO_LONG
    monkeypatch.setattr(module, "MOST_PIECES", 100)
    found = find(text, settings, section)
    assert found.failure.reason == FailureReason.PAST_TOO_LONG
    assert found.failure.reason.halts
    assert 0.0 < found.failure.time < 200.0
    assert len(found.packed_state) == 0


@pytest.mark.parametrize(
    ("text", "event", "reason"),
    [
        (BALL, "hit", FailureReason.ACCUMULATION),
        (RELAY.replace("H}", "x}").replace("parameters: {tau: 1}\n", ""), "e", FailureReason.SLIDING),
    ],
)
def test_a_motion_that_comes_to_a_halt_fails_at_its_event(text, event, reason):
    found = find(text, ReturnSettings(0.0, 0.0, 50.0, 4, 20), ReturnSection(event=event))
    assert (found.failure.reason, found.failure.event) == (reason, event)
    assert found.failure.reason.halts
    assert found.failure.time > 0.9


@given(st.lists(st.floats(-5, 5), min_size=2, max_size=30), st.floats(0.1, 10), st.floats(-3, 3))
def test_a_cloud_covers_the_region_that_it_covers(states, scale, shift):
    a = np.array(states)[:, None]
    assert cover_same_region(a, a[::-1])
    extent = float(np.ptp(a))
    if extent > 1e-3:
        assert not cover_same_region(a, a + extent)
        assert cover_same_region(scale * a + shift, scale * a + shift)


@pytest.mark.parametrize(
    ("later", "stationary"),
    [
        (lambda a: a[::-1], True),
        (lambda a: a + 0.2, True),
        (lambda a: a + 5, False),
        (lambda a: 0.3 * a, False),
        (lambda a: 3 * a, False),
        (lambda a: a[:1], False),
    ],
)
def test_a_stationary_motion_moves_later_as_it_did(later, stationary):
    a = np.random.default_rng(1).normal(size=(32, 2))
    assert is_stationary(a, later(a)) is stationary


@pytest.mark.parametrize(
    ("times", "t_end", "longest", "expected"),
    [
        ([1.0, 2.0, 4.0], 23.9, 0.0, False),
        ([1.0, 2.0, 4.0], 24.1, 0.0, True),
        ([1.0, 2.0, 4.0], 24.1, 21.0, False),
        ([4.0], 1e6, 0.0, False),
    ],
)
def test_a_section_is_left_after_a_long_time(times, t_end, longest, expected):
    assert has_left_section(np.array(times), t_end, longest) is expected
