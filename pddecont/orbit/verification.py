"""Whether an orbit is a motion of the model: a simulation from its own past says so.

From the middle of each segment the orbit's past is simulated to the middle of the next one. The simulation knows
nothing of the signature: it meets what events there are, delayed ones, jumps of delayed values over a surface and
surfaces at which nothing goes on too. It has to meet the event that ends the segment, when it ends, and nothing else,
and to be where the orbit is then. Beginning anew in each segment keeps the orbit's instability out of the comparison.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod, Direct
from pddecont.orbit.admissibility import SIGNS, find_event_profile
from pddecont.orbit.error import estimate_interval_errors, measure_states
from pddecont.orbit.motion import list_started_events
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.past import make_past
from pddecont.orbit.problem import INSTANT
from pddecont.orbit.verdict import NOT_DONE, Verification
from pddecont.reasons import Reason, Scalar, make_reason
from pddecont.simulate import (
    DrivenSimulator,
    FailureReason,
    Method,
    MotionFailure,
    MotionRecord,
    ParameterValues,
    Past,
    Simulator,
    follow_motion,
    restart_motion,
)

Array = NDArray[np.float64]
# Code of the reason that a simulation ends elsewhere than the orbit, after the same events.
DRIFTS = "drifts"
# Where in a segment simulations begin and end: no part that a symmetry of the motion makes special, and others where a
# surface lies just there.
PLACES = (0.4789, 0.3217, 0.6481)
# The error allowed in a step of the simulation, relative to the size of the states.
RTOL, ATOL = 1e-9, 1e-11
# Steps after which a simulation is given up, and done with a stiff method instead.
MAX_STEPS = 4000
# How much more of the past is kept than delays reach back, relative to them.
REACH = 1e-9
# How far simulation and orbit may be apart, relative to the size of the motion: what the errors of the simulation's
# steps add up to, and so many times the orbit's own estimated error.
SIMULATED, ESTIMATED = 1e-7, 30.0
# So many times as far as the orbit's error is carried to in the same time.
CARRIED = 30.0
# The part of its size by which an orbit is moved to see how far errors are carried, where its own error is smaller.
SMALLEST_MOVE = 1e-8


@dataclass(frozen=True, eq=False)
class Referee:
    """Simulates orbits of a model from their own past."""

    numeric: NumericModel
    delay: DelayMethod

    @cached_property
    def simulators(self) -> tuple[Simulator, ...]:
        """The model ready to be integrated, by an explicit method and by one for stiff models.

        Where a delay line holds the history, delayed values are what the orbit says.
        """
        made = DrivenSimulator if self.is_driven else Simulator
        return tuple(made(self.numeric, Direct(), Method(rtol=RTOL, stiff=stiff)) for stiff in (False, True))

    @property
    def is_driven(self) -> bool:
        """Whether the orbit's delayed values are given to the simulation, not read from its past."""
        return self.delay.stages is not None

    def verify(self, orbit: Orbit, *, strict: bool = False) -> Verification:
        """Return whether an orbit is a motion of the model.

        One that lies so near to the border of what its signature can do that its error decides counts as one, unless
        ``strict``.
        """
        found = orbit.once("strict verification", lambda: self._verify(orbit, strict=True))
        if strict or found.verified == 1:
            return found
        return orbit.once("verification", lambda: self._verify(orbit, strict=False))

    def _verify(self, orbit: Orbit, *, strict: bool) -> Verification:
        if not np.all(orbit.durations > INSTANT * orbit.period) or not orbit.period > 0.0:
            return Verification(0, reason=make_reason("no_time"))
        check = _Check(self, orbit, strict)
        # All windows begin at the same place, so that together they hold the whole orbit.
        found = [check.check_all(PLACES[0])]
        while found[-1].verified == 0 and len(found) < len(PLACES):
            found.append(check.check_all(PLACES[len(found)]))
        return found[0] if found[-1].verified == 0 else found[-1]


@dataclass(frozen=True, eq=False)
class _Window:
    """A simulation from a place in segment ``s`` to the same place in the next one: what it starts from and expects."""

    s: int
    begin: float
    event: float
    end: float
    states: Array
    target: Array


@dataclass(frozen=True, eq=False)
class _Check:
    """One orbit under examination."""

    referee: Referee
    orbit: Orbit
    strict: bool

    @cached_property
    def sizes(self) -> Array:
        """The size of each state (n_states,)."""
        return measure_states(self.orbit.values)

    @cached_property
    def error(self) -> float:
        """The orbit's estimated error, relative to its size."""
        return float(np.max(estimate_interval_errors(self.orbit)))

    @cached_property
    def values(self) -> list[ParameterValues]:
        """The model's numbers at the orbit's parameters, for each of the referee's simulators."""
        atol = ATOL * float(np.min(self.sizes))
        return [s.values(self.orbit.parameters)._replace(atol=atol) for s in self.referee.simulators]

    @cached_property
    def past(self) -> Past:
        """The orbit as far back as a delay reaches from any segment."""
        orbit = self.orbit
        if self.referee.is_driven:
            return make_past(orbit, 0.0, 2.0 * orbit.period, delayed=True)
        longest = float(np.max(orbit.numeric.delays.value(orbit.parameters), initial=0.0))
        return make_past(orbit, -longest * (1.0 + REACH), 2.0 * orbit.period)

    @cached_property
    def started(self) -> list[tuple[float, float, str]]:
        """The delayed events that the orbit's events start."""
        return list_started_events(self.orbit)

    def list_windows(self, place: float) -> list[_Window]:
        """Return what is simulated across the end of each segment, from ``place`` in it to that in the next one."""
        orbit, n = self.orbit, len(self.orbit.signature)
        ends = orbit.event_times[1:]
        begins = orbit.event_times[:-1] + place * orbit.durations
        states = orbit.mesh.interpolate(orbit.values, orbit.mesh.locate(orbit.theta, begins)[0])
        beyond = ends + place * np.roll(orbit.durations, -1)
        return [
            _Window(s, float(begins[s]), float(ends[s]), float(beyond[s]), states[s], states[(s + 1) % n])
            for s in range(n)
        ]

    def check_all(self, place: float) -> Verification:
        """Return whether the motion goes on as the orbit does from a place in each segment to that in the next one."""
        worst = 0.0
        for window in self.list_windows(place):
            found = self.judge(window, self.simulate(window))
            if found.verified != 1:
                return found
            worst = max(worst, found.deviation)
        return Verification(1, worst)

    def simulate(self, window: _Window, moved: float = 0.0) -> MotionRecord | None:
        """Return what the motion does in a window; None if it takes too many steps.

        It begins at the orbit, ``moved`` from there relative to the size of the states.
        """
        orbit = self.orbit
        begin = orbit.start + window.begin
        pending = [(orbit.start + t, name) for t, since, name in self.started if since < window.begin < t <= window.end]
        mode = orbit.signature.segments[window.s].mode
        states = window.states + moved * self.sizes
        for simulator, values in zip(self.referee.simulators, self.values, strict=True):
            if self.referee.is_driven:
                ago = (window.end - window.begin) * (1.0 + REACH)
                values = values._replace(tau=np.array([ago]), longest=ago, max_step=min(ago, values.max_step))
                past = self.past.between(begin, orbit.start + window.end).shift(-ago)
            else:
                past = self.past.until(begin)
                past = replace(past, value=past.value + moved * self.sizes) if moved else past
            state = restart_motion(simulator, values, past, begin, states, mode, pending)
            record = follow_motion(simulator, values, state, orbit.start + window.end, MAX_STEPS)
            if record is not None:
                return record
        return None

    def judge(self, window: _Window, record: MotionRecord | None) -> Verification:
        """Return whether what the motion does in a window is what the orbit does."""
        if record is None:
            return replace(NOT_DONE, reason=make_reason("too_many_steps"))
        orbit = self.orbit
        segment = orbit.signature.segments[window.s]
        expected = (segment.name,) if segment.event else ()
        number = window.s + 1
        if record.failure is None and record.segments == expected:
            deviation = self.measure(window, record)
            allowed = SIMULATED + ESTIMATED * self.error
            if deviation <= allowed or deviation <= CARRIED * self.find_carried(window, record):
                return Verification(1, deviation)
            return Verification(0, deviation, make_reason(DRIFTS, number=number, segment=segment.name))
        if not self.strict and self.is_undecided(window, record):
            return Verification(1, 0.0)
        return Verification(0, reason=self.describe(window, record))

    def measure(self, window: _Window, record: MotionRecord) -> float:
        """Return how far simulation and orbit are apart in a window."""
        apart = float(np.max(np.abs(record.states - window.target) / self.sizes))
        if len(record.times):
            late = abs(float(record.times[0]) - self.orbit.start - window.event) / self.orbit.period
            apart = max(apart, late)
        return apart

    def find_carried(self, window: _Window, record: MotionRecord) -> float:
        """Return how far apart motions are at the end of a window that begin as far apart as the orbit is wrong."""
        error = max(self.error, SMALLEST_MOVE)
        farthest = 0.0
        for moved in (error, -error):
            other = self.simulate(window, moved)
            if other is None or other.failure is not None or other.segments != record.segments:
                return np.inf
            farthest = max(farthest, float(np.max(np.abs(other.states - record.states) / self.sizes)))
        return farthest

    def is_undecided(self, window: _Window, record: MotionRecord) -> bool:
        """Return whether the orbit lies at the border of what it does and what the motion does instead.

        Two events come at once, or a surface is only touched, to the orbit's error: rounding decides which happens.
        """
        orbit = self.orbit
        segment = orbit.signature.segments[window.s]
        apart = (SIMULATED + ESTIMATED * self.error) * orbit.period
        events = list(zip(record.times - orbit.start, record.segments, strict=True))
        model = orbit.numeric.model
        wrong = [(t, name) for t, name in events if name != segment.name]
        if segment.event and model.events[segment.event].function is not None and self.is_touched(window.s):
            return True
        for t, name in wrong[:1]:
            if segment.event and abs(t - window.event) <= apart:
                return True
            event = model.segments[name].event
            within = window.s if t < window.event else (window.s + 1) % len(orbit.signature)
            if model.events[event].function is not None and self.is_near(event, within):
                return True
        return False

    def is_touched(self, s: int) -> bool:
        """Return whether segment ``s`` meets the surface of its event so slowly that it may miss it."""
        event = self.orbit.signature.segments[s].event
        profile = find_event_profile(self.orbit, event)
        largest = float(np.max(np.abs(profile.values)))
        rate = abs(profile.end_slope(s)) * self.orbit.period
        return bool(rate <= 10.0 * np.sqrt(SIMULATED + ESTIMATED * self.error) * largest)

    def is_near(self, event: str, s: int) -> bool:
        """Return whether the function of ``event`` in segment ``s`` goes beyond zero by no more than errors do."""
        orbit = self.orbit
        watched = {w.event: w for w in orbit.signature.list_watched_events(s)}
        if event not in watched:
            return False
        profile = find_event_profile(orbit, event)
        largest = float(np.max(np.abs(profile.values)))
        near = (SIMULATED + ESTIMATED * self.error) * largest
        sign = SIGNS.get(watched[event].direction)
        levels = [e.value for e in profile.extrema if e.segment == s]
        if sign is None:
            return any(abs(level) <= near for level in levels)
        # What is crossed by no more than this is touched.
        return any(abs(level) <= near for level in (*levels, *profile.ends(s)))

    def describe(self, window: _Window, record: MotionRecord) -> Reason:
        """Return what the motion does in a window instead of what the orbit does."""
        orbit = self.orbit
        segment = orbit.signature.segments[window.s]
        where: dict[str, Scalar] = {"number": window.s + 1, "segment": segment.name}
        if record.failure is not None:
            return _describe_failure(record.failure, where)
        wrong = next(
            ((t, name) for t, name in zip(record.times, record.segments, strict=True) if name != segment.name), None
        )
        if wrong is None:
            return Reason("missing", {"event": segment.event, **where})
        t, name = wrong
        place = int(t - orbit.start >= window.event)
        number = (window.s + place) % len(orbit.signature)
        return make_reason(
            "happens",
            number=number + 1,
            segment=orbit.signature.names[number],
            event=orbit.numeric.model.segments[name].event,
            instead=name,
            time=float(t - orbit.start),
        )


def _describe_failure(failure: MotionFailure, where: dict[str, Scalar]) -> Reason:
    code = "slides" if failure.reason == FailureReason.SLIDING else "halts"
    values: dict[str, Scalar] = {"event": failure.event or "", "mode": failure.mode or "", "why": failure.reason.value}
    return Reason(code, {**where, **values})
