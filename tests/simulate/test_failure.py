"""The sentences that files and messages have for each failure."""

import pickle

import pytest

from pddecont.reasons import reason_from_json
from pddecont.simulate import FailureReason, MotionFailure, describe_failure, failure_from_reason, failure_to_reason

SENTENCES = {
    FailureReason.ACCUMULATION: "events of 'hit' accumulate at t = 1.23456789012 (Zeno): the motion comes to rest "
    "there. Write a mode for it and name it in the step, 'stick: {hit: MODE}'",
    FailureReason.SLIDING: "event 'hit' leads, at t = 1.23456789012, to a mode whose flow leads straight back: both "
    "point at the surface (the motion slides along it). Write a mode for sliding and name it in the step, "
    "'stick: {hit: MODE}'",
    FailureReason.UNDEFINED: "the simulation ends at t = 1.23456789 in mode 'fly': log(x) takes the logarithm of zero",
    FailureReason.NOT_FINITE: "the solution is no longer finite near t = 1.23456789 in mode 'fly'; it grows without "
    "bound there, or the vector field cannot be evaluated: check its logarithms, roots and divisions",
    FailureReason.STEP_TOO_SMALL: "no step is small enough near t = 1.23456789 in mode 'fly': the solution grows "
    "without bound there, or the vector field has a singularity or a jump that no event marks; a stiff model wants "
    "'method: stiff'",
    FailureReason.SECTION_LEFT: "the motion no longer returns to the section after t = 1.23457",
    FailureReason.NO_RETURN: "the motion does not come back to the section in the time of the transient",
    FailureReason.NOT_SETTLED: "the motion has not settled in the time of the transient: its last returns still move, "
    "die away or grow; raise 'transient'",
    FailureReason.EQUILIBRIUM: "the motion stays at an equilibrium or dies away to it: its returns to the section mean "
    "nothing",
}


@pytest.mark.parametrize("reason", FailureReason)
def test_each_reason_has_its_sentence(reason):
    failure = MotionFailure(reason, 1.234567890123, "hit", "fly", "log(x) takes the logarithm of zero")
    assert describe_failure(failure) == SENTENCES[reason]


@pytest.mark.parametrize("reason", FailureReason)
def test_files_are_read_back_to_the_same_failure(reason):
    failure = MotionFailure(reason, 1.234567890123, "hit", "fly", "log(x) takes the logarithm of zero")
    assert failure_from_reason(reason_from_json(failure_to_reason(failure).to_json())) == failure


def test_what_a_failure_has_not_is_not_written():
    assert failure_to_reason(MotionFailure(FailureReason.NO_RETURN)).values == {}


def test_failures_are_alike_by_reason_and_event_alone():
    a = MotionFailure(FailureReason.ACCUMULATION, 1.0, "hit", "fly")
    assert a.is_like(MotionFailure(FailureReason.ACCUMULATION, 2.0, "hit", "lie", "other"))
    assert not a.is_like(MotionFailure(FailureReason.ACCUMULATION, 1.0, "stop", "fly"))
    assert not a.is_like(MotionFailure(FailureReason.SLIDING, 1.0, "hit", "fly"))


def test_a_motion_goes_on_unless_its_integration_halted():
    halting = {r for r in FailureReason if r.halts}
    assert halting == set(FailureReason) - {
        FailureReason.SECTION_LEFT,
        FailureReason.NO_RETURN,
        FailureReason.NOT_SETTLED,
        FailureReason.EQUILIBRIUM,
    }


def test_failures_travel():
    failure = MotionFailure(FailureReason.SLIDING, 1.0, "hit", "fly")
    assert pickle.loads(pickle.dumps(failure)) == failure
