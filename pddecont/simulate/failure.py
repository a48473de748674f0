"""Why a motion leads to no attractor, as data, and the sentence that says so."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from pddecont.reasons import Reason, Scalar


class FailureReason(Enum):
    """What a motion does instead of settling."""

    ACCUMULATION = "accumulation"  # events accumulate, and nothing says which mode follows
    SLIDING = "sliding"  # two vector fields point at the surface of an event
    REPELLED = "repelled"  # two vector fields point away from a surface that it is on
    UNDEFINED = "undefined"  # the vector field has no value
    NOT_FINITE = "not finite"  # the solution is infinite or NaN
    STEP_TOO_SMALL = "step too small"  # no step meets the tolerances
    ADVANCED = "advanced"  # a delay is below zero
    PAST_UNKNOWN = "past unknown"  # a delay reaches farther back than the past is known
    PAST_TOO_LONG = "past too long"  # more steps in the longest delay than are kept
    SECTION_LEFT = "section left"  # it does not return to the section any more
    NO_RETURN = "no return"  # it does not return to the section in time
    NOT_SETTLED = "not settled"  # its returns still move when its time is over
    EQUILIBRIUM = "equilibrium"  # it rests, so that returns to the section mean nothing

    @property
    def halts(self) -> bool:
        """Whether the integration came to a halt, so that the motion cannot go on."""
        return self in HALTS


HALTS = (
    FailureReason.ACCUMULATION,
    FailureReason.SLIDING,
    FailureReason.REPELLED,
    FailureReason.UNDEFINED,
    FailureReason.NOT_FINITE,
    FailureReason.STEP_TOO_SMALL,
    FailureReason.ADVANCED,
    FailureReason.PAST_UNKNOWN,
    FailureReason.PAST_TOO_LONG,
)


@dataclass(frozen=True)
class MotionFailure:
    """Why a motion leads to no attractor.

    Attributes
    ----------
    reason
        What it does instead.
    time
        When it comes to a halt or returns last; NaN where there is no such time.
    event, mode
        The event that it comes to a halt at, if it is one, or the switch whose surface repels it, and the mode that it
        is in.
    detail
        Which part of the vector field has no value, and why; which surface repels it, where, and how; which delay is
        below zero, and its value.
    is_stiff
        Whether the method for stiff models was used.
    """

    reason: FailureReason
    time: float = math.nan
    event: str | None = None
    mode: str | None = None
    detail: str = ""
    is_stiff: bool = False

    def is_like(self, other: MotionFailure) -> bool:
        """Return whether two motions fail in one way: for one reason, at one event."""
        return (self.reason, self.event) == (other.reason, other.event)


def describe_failure(failure: MotionFailure) -> str:
    """Return the sentence that says why a motion leads to no attractor, with advice."""
    t, event, mode = failure.time, failure.event, failure.mode
    match failure.reason:
        case FailureReason.ACCUMULATION:
            return (
                f"events of '{event}' accumulate at t = {t:.12g} (Zeno): the motion comes to rest there. Write a mode "
                f"for it and name it in the step, 'stick: {{{event}: MODE}}', or in the segment, 'rest: MODE'; a jump "
                "of equations says 'rest: true'"
            )
        case FailureReason.SLIDING:
            return (
                f"event '{event}' leads, at t = {t:.12g}, to a mode whose flow leads straight back: both point at the "
                f"surface (the motion slides along it). Write a mode for sliding and name it in the step, 'stick: "
                f"{{{event}: MODE}}'"
            )
        case FailureReason.REPELLED:
            return (
                f"at t = {t:.12g} the motion is {failure.detail}; let it start, or jump, beside the surface, or "
                "give the 'mode' in which it starts"
            )
        case FailureReason.UNDEFINED:
            return f"the simulation ends at t = {t:.10g} in mode '{mode}': {failure.detail}"
        case FailureReason.NOT_FINITE:
            return (
                f"the solution is no longer finite near t = {t:.10g} in mode '{mode}'; it grows without bound there, "
                "or the vector field cannot be evaluated: check its logarithms, roots and divisions"
            )
        case FailureReason.STEP_TOO_SMALL:
            return (
                f"no step is small enough near t = {t:.10g} in mode '{mode}': the solution grows without bound there, "
                "or the vector field has a singularity or a jump that no event marks; "
                + (
                    "'method: stiff' is used already: where the solution is smooth, 'rtol' and 'atol' ask for more "
                    "than rounding leaves"
                    if failure.is_stiff
                    else "a stiff model wants 'method: stiff'"
                )
            )
        case FailureReason.ADVANCED:
            return (
                f"at t = {t:.12g} the delay {failure.detail}: from there on the equation would read the future; "
                "let the delay stay positive"
            )
        case FailureReason.PAST_UNKNOWN:
            return (
                f"at t = {t:.12g} a delay reaches farther back than the past is known: it has grown to several times "
                "its longest value before, or the motion began from a piece of another one"
            )
        case FailureReason.PAST_TOO_LONG:
            return (
                f"at t = {t:.12g} the motion has made so many steps within the longest delay that it is given up: "
                "jumps of its rates, or events, come back through delays and become ever more; raise 'rtol' and "
                "'atol', or shorten 'transient'"
            )
        case FailureReason.SECTION_LEFT:
            return f"the motion no longer returns to the section after t = {t:.6g}"
        case FailureReason.NO_RETURN:
            return "the motion does not come back to the section in the time of the transient"
        case FailureReason.NOT_SETTLED:
            return (
                "the motion has not settled in the time of the transient: its last returns still move, die away or "
                "grow; raise 'transient'"
            )
        case FailureReason.EQUILIBRIUM:
            return "the motion stays at an equilibrium or dies away to it: its returns to the section mean nothing"


def failure_to_reason(failure: MotionFailure) -> Reason:
    """Return a failure as results files keep it."""
    values: dict[str, Scalar] = {} if math.isnan(failure.time) else {"time": failure.time}
    texts = {"event": failure.event, "mode": failure.mode, "detail": failure.detail}
    if failure.is_stiff:
        values["stiff"] = True
    return Reason(failure.reason.value, {**values, **{name: text for name, text in texts.items() if text}})


def failure_from_reason(reason: Reason) -> MotionFailure:
    """Return the failure that :func:`failure_to_reason` wrote; raise ValueError if it is none."""
    values = {name: str(reason.values[name]) for name in ("event", "mode", "detail") if name in reason.values}
    time, is_stiff = float(reason.values.get("time", math.nan)), bool(reason.values.get("stiff", False))
    return MotionFailure(FailureReason(reason.code), time, **values, is_stiff=is_stiff)
