"""The period and the signature of the motion that a trajectory has settled to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.errors import SignatureError
from pddecont.model import Model
from pddecont.simulate.trajectory import Trajectory
from pddecont.simulate.trend import STILL, find_decay, find_growing_state, is_at_rest, measure_noise

Array = NDArray[np.float64]
# The longest period that is looked for, in periods of the forcing or passages; four times as many events.
MAX_PERIODS, EVENTS_PER_PERIOD = 64, 4
# A motion repeats itself where it comes back to this part of its size; Newton's method does the rest for an orbit.
CLOSE = 1e-4
# Gaps between the same events may differ by this part of the period.
SAME_GAPS = 1e-3
# An autonomous motion moves some state by so many times the errors of steps at least.
MOVES = 10.0
# Where between two events a state is compared: a part that no symmetry of the motion makes special.
OFF_CENTRE = 0.4789
# Places in a period at which states are compared.
N_PLACES = 24
# A passage is located to 2^-60 of a step.
BISECTIONS = 60
NO_PERIODIC_MOTION = (
    "and there is no periodic motion to find. Change the parameters so that it oscillates, keep the effects that drive "
    "it, or start elsewhere ('initial')"
)
AT_REST = f"the motion comes to rest: the trajectory settles to an equilibrium, {NO_PERIODIC_MOTION}"


@dataclass(frozen=True, eq=False)
class Cycle:
    """The last period of a trajectory.

    Attributes
    ----------
    signature
        The names of its segments; empty for a motion without events.
    times
        Where they begin and end (n_segments + 1,).
    arcs
        Their numbers in the trajectory.
    n_periods
        Periods of the forcing in it; 1 for an autonomous model.
    mode
        The mode at its start.
    trajectory
        The trajectory.
    """

    signature: tuple[str, ...]
    times: Array
    arcs: tuple[int, ...]
    n_periods: int
    mode: str
    trajectory: Trajectory

    def evaluate(self, segment: int, t: Array) -> Array:
        """Return the states at times ``t`` in a segment, shape (n_times, n_states)."""
        return self.trajectory.evaluate_arc(self.arcs[segment], t)


def detect_period(numeric: NumericModel, p: Array, trajectory: Trajectory) -> Cycle:
    """Return the cycle that the end of ``trajectory`` repeats.

    Raises
    ------
    SignatureError
        If the trajectory has not settled to a periodic motion, with the nearest return found and what to try; if it has
        come to rest.
    """
    if numeric.model.forced:
        return _detect_forced(numeric.model, trajectory, float(numeric.period.value(p)[0]))
    if len(trajectory.events):
        return _detect_by_events(numeric.model, trajectory)
    return _detect_by_section(numeric.model, trajectory)


def _detect_forced(model: Model, trajectory: Trajectory, period: float) -> Cycle:
    """Return the cycle of a forced trajectory: the least number of forcing periods after which it comes back."""
    end = _find_end(trajectory, period)
    most = min(MAX_PERIODS, int(0.5 * (end - trajectory.t0) / period))
    if most < 1:
        raise SignatureError(
            f"of the trajectory {(end - trajectory.t0) / period:.3g} forcing periods ({period:.6g}) are kept up to t = "
            f"{end:.6g}, shorter than two forcing periods; raise 't_end', or record from an earlier time"
        )
    offsets = np.linspace(0.0, 1.0, N_PLACES, endpoint=False) * period
    recent = trajectory(end - offsets)
    size, noise = _measure_size(recent), measure_noise(trajectory, recent)
    distances = [
        _measure_distance(recent, trajectory(end - offsets - k * period), size, noise) for k in range(1, most + 1)
    ]
    for k, distance in enumerate(distances, 1):
        if distance < CLOSE:
            cycle = _find_cycle(trajectory, end, k * period, k)
            if cycle is not None:
                return cycle
    raise _make_error(model, trajectory, distances, [k * period for k in range(1, most + 1)], "forcing periods")


def _find_end(trajectory: Trajectory, period: float) -> float:
    """Return a time near the end, away from events: there a state has two values, and returns could not be compared."""
    for turns in (3.0, 2.0, 1.0):
        times = trajectory.events.t[trajectory.events.t > trajectory.t_end - turns * period]
        if len(times) < 2:
            break
        longest = int(np.argmax(np.diff(times)))
        end = float(times[longest] + OFF_CENTRE * (times[longest + 1] - times[longest]))
        # The widest gap may lie so early that too little is left before it.
        if end - trajectory.t0 >= 2.0 * period:
            return end
    return trajectory.t_end


def _find_cycle(trajectory: Trajectory, end: float, length: float, n_periods: int) -> Cycle | None:
    """Return the last ``length`` of the trajectory, from event to event; None if its events do not repeat."""
    events = trajectory.events
    inside = np.flatnonzero((end - length < events.t) & (events.t <= end))
    if not len(inside):
        return Cycle(
            (), np.array([end - length, end]), (int(trajectory.arc[-1]),), n_periods, trajectory.mode[-1], trajectory
        )
    last = int(inside[-1])
    # Of impacts that accumulate one more or less may have been followed in the period before.
    alike = [k for k in range(last) if events.segment[k] == events.segment[last]]
    first = min(alike, key=lambda k: abs(events.t[last] - events.t[k] - length), default=None)
    if first is None or abs(events.t[last] - events.t[first] - length) > SAME_GAPS * length:
        return None
    return _make_cycle(trajectory, first, last, n_periods)


def _make_cycle(trajectory: Trajectory, first: int, last: int, n_periods: int) -> Cycle:
    """Return the cycle between two events.

    The segment that lasts longest comes first; the trajectory may hold one more turn before, so that any segment can.
    """
    events = trajectory.events
    count = last - first
    lengths = np.diff(events.t[first : last + 1])
    turn = min(range(count), key=lambda i: -lengths[i])
    begin = first + turn - count
    if begin >= 0 and events.segment[begin + 1 : first + 1] == events.segment[begin + 1 + count : first + 1 + count]:
        first = begin
    arcs = tuple(int(arc) for arc in events.arc[first : first + count])
    return Cycle(
        events.segment[first + 1 : first + 1 + count],
        events.t[first : first + count + 1],
        arcs,
        n_periods,
        trajectory.find_mode(arcs[0]),
        trajectory,
    )


def _detect_by_events(model: Model, trajectory: Trajectory) -> Cycle:
    """Return the cycle of an autonomous trajectory: the least number of events after which they repeat."""
    events = trajectory.events
    states = events.after
    # At its events a motion may always be in one state: its size is that of the arcs between them.
    recent = trajectory(np.linspace(events.t[-min(len(events), 9)], trajectory.t_end, 200))
    recent = np.concatenate([states[-200:], recent])
    size, noise = _measure_size(recent), measure_noise(trajectory, recent)
    most = min(MAX_PERIODS * EVENTS_PER_PERIOD, (len(events) - 1) // 2)
    distances, lengths = [], []
    for q in range(1, most + 1):
        same = events.segment[-q:] == events.segment[-2 * q : -q]
        gaps = events.t[-q:] - events.t[-2 * q : -q]
        distance = _measure_distance(states[-q:], states[-2 * q : -q], size, noise) if same else np.inf
        distance = max(distance, float(np.ptp(gaps) / np.max(gaps))) if same else np.inf
        distances.append(distance)
        lengths.append(float(events.t[-1] - events.t[-1 - q]))
        if distance < CLOSE:
            return _make_cycle(trajectory, len(events) - 1 - q, len(events) - 1, 1)
    raise _make_error(model, trajectory, distances, lengths, "events")


def _detect_by_section(model: Model, trajectory: Trajectory) -> Cycle:
    """Return the cycle of a smooth autonomous trajectory, from its upward passages through a section."""
    t, x, _ = trajectory.sample()
    late = t > t[0] + 0.5 * (t[-1] - t[0])
    swing, noise = np.ptp(x[late], axis=0), measure_noise(trajectory, x[late])
    if np.all(swing < STILL * (1e-300 + np.max(np.abs(x[late]), axis=0)) + noise):
        raise SignatureError(AT_REST)
    state = int(np.argmax(swing / (np.max(np.abs(x[late]), axis=0) + 1e-300)))
    level = 0.5 * (x[late, state].min() + x[late, state].max())
    up = np.flatnonzero(late[:-1] & (x[:-1, state] < level) & (x[1:, state] >= level))
    passages = []
    for i in up:
        a, b = t[i], t[i + 1]
        for _ in range(BISECTIONS):
            middle = 0.5 * (a + b)
            a, b = (middle, b) if trajectory(middle)[state] < level else (a, middle)
        passages.append(b)
    points = trajectory(np.array(passages))
    distances, lengths = [], []
    for q in range(1, min(MAX_PERIODS, (len(passages) - 1) // 2) + 1):
        gaps = np.array([passages[-1 - i] - passages[-1 - i - q] for i in range(q)])
        distance = max(
            _measure_distance(points[-q:], points[-2 * q : -q], swing, noise), float(np.ptp(gaps) / np.max(gaps))
        )
        length = passages[-1] - passages[-1 - q]
        grid = np.linspace(0.0, length, N_PLACES)
        here, there = (trajectory(passages[-1] - back - grid) for back in (0.0, length))
        # What errors of steps alone make of a motion at rest is no motion.
        moves = np.any(np.ptp(here, axis=0) > MOVES * noise)
        is_seen = moves and passages[-1] - 2 * length > t[0]
        distance = max(distance, _measure_distance(here, there, swing, noise)) if is_seen else np.inf
        distances.append(distance)
        lengths.append(length)
        if distance < CLOSE:
            times = np.array([passages[-1] - length, passages[-1]])
            return Cycle((), times, (int(trajectory.arc[-1]),), 1, trajectory.mode[-1], trajectory)
    raise _make_error(model, trajectory, distances, lengths, "passages")


def _measure_size(states: Array) -> Array:
    """Return how large each state of a motion is, shape (n_states,)."""
    size: Array = np.ptp(states, axis=0) + 1e-9 * np.max(np.abs(states), axis=0) + 1e-300
    return size


def _measure_distance(a: Array, b: Array, size: Array, noise: Array) -> float:
    """Return how far apart two sets of states are beyond the errors of steps, relative to the size of the motion."""
    return max(0.0, float(np.max((np.abs(a - b) - noise) / (size + 1e-300))))


def _make_error(
    model: Model, trajectory: Trajectory, distances: list[float], lengths: list[float], what: str
) -> SignatureError:
    """Return what to raise for a trajectory that does not repeat itself: what it does instead, the nearest return."""
    if is_at_rest(trajectory):
        return SignatureError(AT_REST)
    decay = find_decay(trajectory)
    if decay is not None:
        return SignatureError(
            f"the motion decays to rest: its swings shrink by a factor of {decay.factor:.2g} in each time "
            f"{decay.length:.4g} up to the end of the trajectory, {NO_PERIODIC_MOTION}"
        )
    growing = find_growing_state(trajectory)
    grows = ""
    if growing is not None:
        state, first, last = growing
        grows = (
            f"state '{model.states[state]}' goes on from {first:.6g} to {last:.6g} in one direction up to the end of "
            "the trajectory, where a periodic motion brings every state back. If it is a clock, see that each mode, "
            f"'{trajectory.mode[-1]}' too, has a segment that resets it"
        )
    if not distances:
        return SignatureError(grows or f"the trajectory holds too few {what} to see a period in them; raise 't_end'")
    best = int(np.argmin(distances))
    return SignatureError(
        f"the trajectory has not settled to a periodic motion: of returns after 1 to {len(distances)} {what} the "
        f"nearest, after time {lengths[best]:.6g}, misses by {distances[best]:.2g} of the motion's size ({CLOSE:g} is "
        "needed). If the motion is still settling, raise 't_end'; "
        + (grows or "if it is quasi-periodic or chaotic, change the parameters or the initial state")
    )
