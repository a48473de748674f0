"""What the motions of a sweep settle to, looked at closely enough to tell whether they lie on a branch."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError, SignatureError
from pddecont.exploration import Fingerprint, Survey, fingerprint_rest, fingerprint_trajectory
from pddecont.results import Step
from pddecont.runfile import Plan
from pddecont.simulate import (
    Attractor,
    FailureReason,
    LyapunovExponent,
    Simulator,
    Trajectory,
    detect_period,
    find_lyapunov_exponent,
)
from pddecont.steps.execution.attractor_restart import follow_attractor, read_task
from pddecont.steps.execution.attractor_rows import attractor_from_row

Array = NDArray[np.float64]
# Returns of a motion without period that are looked at.
IRREGULAR_RETURNS = 40
# Returns in which the period of a motion is looked for that settles slowly.
SLOW_RETURNS = 140
# A motion that covers less than this part of its place, or of how far motions of the model go, is at rest.
STILL = 1e-5
# A motion that is farther than so many times what motions of the model cover goes away.
FAR = 10.0
# How often the time to settle is given once more to a motion that has not settled.
LONGER = 3.0
# The part of the time to settle for which a motion that does not come back to the section is followed on.
FURTHER = 0.1
# An exponent that is surely smaller than this in one return is zero; it is known to so many of its uncertainties.
NEUTRAL, UNCERTAINTIES = 2e-2, 3.0


class LookCode(StrEnum):
    """What a motion looks like."""

    PERIODIC = "periodic"
    REST = "rest"
    IRREGULAR = "irregular"
    UNSETTLED = "unsettled"
    CHAOS = "chaos"
    TORUS = "torus"
    AWAY = "away"
    HALTED = "halted"


@dataclass(frozen=True, eq=False)
class Look:
    """A motion that a sweep found: where it stands there, its parameters, what it looks like.

    ``motion`` is None of one that came to a halt, ``detail`` why it did.
    """

    sweep: str
    point: str
    row: int
    parameters: Array
    code: LookCode
    motion: Fingerprint | None = None
    exponent: LyapunovExponent = field(default_factory=LyapunovExponent)
    detail: str = ""

    @property
    def can_start_orbit(self) -> bool:
        """Whether an orbit step can start from it."""
        return self.code == LookCode.PERIODIC and bool(self.point)  # one that failed has no label


def look_at_sweep(plan: Plan, recorded: Step, survey: Survey) -> list[Look]:
    """Return what each motion of a sweep looks like; ``survey`` tells how far others go."""
    simulator = read_task(plan, recorded).make_simulator()
    return [_look(plan, simulator, recorded, row, survey) for row in range(len(recorded))]


def _look(plan: Plan, simulator: Simulator, recorded: Step, row: int, survey: Survey) -> Look:
    attractor = attractor_from_row(recorded, row)
    look = Look(recorded.name, recorded.labels[row], row, attractor.p, LookCode.HALTED)
    failure = attractor.failure
    if failure is not None and failure.reason.halts:
        return replace(look, detail=failure.reason.value)
    try:
        if attractor.period > 0:
            trajectory = follow_attractor(simulator, attractor, attractor.turn, recorded.name)
            code, motion = LookCode.PERIODIC, fingerprint_trajectory(trajectory, attractor.turn)
        else:
            duration, after = _choose_duration(plan, recorded, attractor)
            trajectory = follow_attractor(simulator, attractor, duration, recorded.name, after=after)
            code, motion = _judge(plan, attractor, trajectory, survey)
    except ConvergenceError as exc:
        return replace(look, detail=str(exc))
    detail = "" if failure is None or code == LookCode.REST else failure.reason.value
    return replace(look, code=code, motion=motion, detail=detail)


def _choose_duration(plan: Plan, recorded: Step, attractor: Attractor) -> tuple[float, float]:
    """Return for how long a motion without a known period is looked at, and after which time."""
    settling = plan.find_step(recorded.name).settings.settling
    transient = float(settling.make_return_settings(plan.numeric, attractor.p).transient)
    is_late = attractor.failure is not None and attractor.failure.reason == FailureReason.NOT_SETTLED
    after = LONGER * transient if is_late else 0.0
    n_returns = len(attractor.times)
    if n_returns > 1 and (attractor.failure is None or is_late):
        return IRREGULAR_RETURNS * float(np.mean(np.diff(attractor.times))), after
    return FURTHER * transient, after


def _judge(plan: Plan, attractor: Attractor, trajectory: Trajectory, survey: Survey) -> tuple[LookCode, Fingerprint]:
    """Return what a motion looks like that a sweep found no period of."""
    whole = fingerprint_trajectory(trajectory, np.nan)
    place = np.maximum(np.abs(whole.values[2]), survey.high - survey.low)
    if _is_away(whole, survey):
        return LookCode.AWAY, whole
    if not plan.model.forced and np.all(whole.highest - whole.lowest <= STILL * place):
        return LookCode.REST, fingerprint_rest(whole.values[2])
    if attractor.failure is None:
        # Its returns were looked at for a period.
        return LookCode.IRREGULAR, whole
    try:
        return _find_period(plan, attractor.p, trajectory)
    except SignatureError:
        return LookCode.IRREGULAR, whole


def _is_away(motion: Fingerprint, survey: Survey) -> bool:
    """Return whether a motion goes much farther than motions of the model do."""
    reach = np.maximum(np.abs(survey.low), np.abs(survey.high))
    return bool(np.any(np.maximum(np.abs(motion.lowest), np.abs(motion.highest)) > FAR * reach))


def _find_period(plan: Plan, p: Array, trajectory: Trajectory) -> tuple[LookCode, Fingerprint]:
    """Return what a motion looks like that repeats itself; raise SignatureError if it does not."""
    cycle = detect_period(plan.numeric, p, trajectory)
    begin, end = float(cycle.times[0]), float(cycle.times[-1])
    return LookCode.PERIODIC, fingerprint_trajectory(trajectory, end - begin, begin, end)


def name_irregular(plan: Plan, recorded: Step, look: Look, survey: Survey) -> Look:
    """Return what a motion without period is, by its largest Lyapunov exponent; ``survey`` tells how far others go.

    It is chaos, a torus, a periodic motion that others near to it settle to so slowly that it was not seen yet, or one
    that goes away so slowly.
    """
    task = read_task(plan, recorded)
    attractor = attractor_from_row(recorded, look.row)
    is_late = attractor.failure is not None and attractor.failure.reason == FailureReason.NOT_SETTLED
    if task.method.stiff or task.method.stick or (attractor.failure is not None and not is_late):
        return look
    simulator = task.make_simulator()
    settling = plan.find_step(recorded.name).settings.settling
    duration = float(settling.make_return_settings(plan.numeric, attractor.p).transient)
    values = simulator.values(attractor.p)
    exponent = find_lyapunov_exponent(simulator, values, replace(attractor, failure=None), duration)
    between = float(np.mean(np.diff(attractor.times))) if len(attractor.times) > 1 else 1.0
    doubt = UNCERTAINTIES * exponent.uncertainty
    look = replace(look, exponent=exponent)
    if exponent.value > max(NEUTRAL / between, doubt):
        return replace(look, code=LookCode.CHAOS)
    try:
        trajectory = follow_attractor(
            simulator, attractor, SLOW_RETURNS * between, recorded.name, after=LONGER * duration
        )
        whole = fingerprint_trajectory(trajectory, np.nan)
        if _is_away(whole, survey):
            return replace(look, code=LookCode.AWAY, motion=whole)
        code, motion = _find_period(plan, attractor.p, trajectory)
    except (ConvergenceError, SignatureError):
        if attractor.failure is not None or exponent.value < -doubt:
            return replace(look, code=LookCode.UNSETTLED)
        # An exponent that is not known to be small does not tell a torus from weak chaos.
        return replace(look, code=LookCode.TORUS if abs(exponent.value) + doubt < NEUTRAL / between else look.code)
    return replace(look, code=code, motion=motion)
