"""The sentences that files and messages have for each failure."""

import pickle

import pytest

from pddecont.errors import ConvergenceError
from pddecont.reasons import reason_from_json
from pddecont.simulate import (
    FailureReason,
    Method,
    MotionFailure,
    describe_failure,
    failure_from_reason,
    failure_to_reason,
)
from tests.simulate.motions import trajectory_of

SENTENCES = {
    FailureReason.ACCUMULATION: "events of 'hit' accumulate at t = 1.23456789012 (Zeno): the motion comes to rest "
    "there. Write a mode for it and name it in the step, 'stick: {hit: MODE}', or in the segment, 'rest: MODE'; a jump "
    "of equations says 'rest: true'",
    FailureReason.SLIDING: "event 'hit' leads, at t = 1.23456789012, to a mode whose flow leads straight back: both "
    "point at the surface (the motion slides along it). Write a mode for sliding and name it in the step, "
    "'stick: {hit: MODE}'",
    FailureReason.REPELLED: "at t = 1.23456789012 the motion is log(x) takes the logarithm of zero; let it start, or "
    "jump, beside the surface, or give the 'mode' in which it starts",
    FailureReason.UNDEFINED: "the simulation ends at t = 1.23456789 in mode 'fly': log(x) takes the logarithm of zero",
    FailureReason.NOT_FINITE: "the solution is no longer finite near t = 1.23456789 in mode 'fly'; it grows without "
    "bound there, or the vector field cannot be evaluated: check its logarithms, roots and divisions",
    FailureReason.STEP_TOO_SMALL: "no step is small enough near t = 1.23456789 in mode 'fly': the solution grows "
    "without bound there, or the vector field has a singularity or a jump that no event marks; a stiff model wants "
    "'method: stiff'",
    FailureReason.ADVANCED: "at t = 1.23456789012 the delay log(x) takes the logarithm of zero: from there on the "
    "equation would read the future; let the delay stay positive",
    FailureReason.PAST_UNKNOWN: "at t = 1.23456789012 a delay reaches farther back than the past is known: it has "
    "grown to several times its longest value before, or the motion began from a piece of another one",
    FailureReason.PAST_TOO_LONG: "at t = 1.23456789012 the motion has made so many steps within the longest delay that "
    "it is given up: jumps of its rates, or events, come back through delays and become ever more; raise 'rtol' and "
    "'atol', or shorten 'transient'",
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


def test_a_run_that_is_stiff_already_is_not_told_to_be():
    failure = MotionFailure(FailureReason.STEP_TOO_SMALL, 1.0, None, "fly", is_stiff=True)
    assert "a stiff model wants" not in describe_failure(failure)
    assert "'method: stiff' is used already" in describe_failure(failure)
    assert failure_from_reason(reason_from_json(failure_to_reason(failure).to_json())) == failure


def test_the_method_of_a_motion_is_known_where_it_fails():
    """x' = x^2 from 1 is infinite at t = 1."""
    text = "name: b\nstates: [x]\nmodes: {m: {x': x**2}}\ninitial: {x: 1}\n"
    for is_stiff in (True, False):
        with pytest.raises(ConvergenceError) as error:
            trajectory_of(text, 2.0, Method(stiff=is_stiff))
        assert ("a stiff model wants" in str(error.value)) is not is_stiff


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
