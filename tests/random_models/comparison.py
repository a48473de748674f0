"""What a motion computed apart says of a recorded orbit: whether it comes back, with the same events, and how far off.

How small perturbations of it grow is compared with its multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.models.method_of_steps import MotionError

# How many error estimates an orbit may be away from the motion, after what a period magnifies; and what the
# integration apart may itself be off, in sizes of the states.
ESTIMATES, FLOOR = 10.0, 1e-8
# An orbit whose error estimate may become so much within a period is too sensitive to be told from others.
SENSITIVE, TOO_SENSITIVE = 1e-3, "too sensitive"
AT_LIMIT = " (at the limit)"
# Places in each segment where states are compared.
PLACES = np.array([0.2, 0.5, 0.8, 1.0])
# Perturbations, relative to the sizes of the states, and how far multipliers may be from their growth.
SMALL, GROWTH_TOL = 2e-4, 2e-3
# The change of the past whose growth within a period is measured.
TINY = 1e-6
# The tolerances of a finer integration, in those of the plain one.
FINER = 1e-2
# Motions that begin half as far apart stay half as far apart, to this part of it, or they obey no linear recurrence.
LINEAR = 0.1
# Distances above this are too large for what is linear.
LARGE = 0.03
# Distances obey a recurrence that misses them by less than this part.
RECURRENCE = 2e-4
# Distances below this are lost in the integration's own errors.
NOISE = 5e-8
# Echoes of the past's events that steps land on: sums of so many delays.
ECHOES = 3


@dataclass(frozen=True)
class Verdict:
    """What became of one period: ``fault`` is empty where the orbit is a motion.

    ``deviation`` is the largest distance, in sizes of the states, ``allowed`` what the error estimate explains.
    """

    fault: str = ""
    deviation: float = np.nan
    allowed: float = np.nan


def start_motion(model, orbit, begin, perturbation=None):
    """Return the motion whose past is the orbit (with a perturbation added), from the time ``begin``.

    Clocks that the orbit's events started and breaking points that they cause are under way.
    """
    segment = int(np.searchsorted(orbit.ends, begin + 1e-9 * orbit.period, side="right"))
    parameters, names = orbit.parameters, orbit.names
    mode = names[0][1:-1] if orbit.eventless else model.segments[names[segment]].mode
    delays = [parameters[d] for d in model.delays]
    clocks = model.clocks(parameters)
    pending, breaks, longest = [], [], ECHOES * max(delays, default=0.0)
    if not orbit.eventless:
        lags = [lag for started in clocks.values() for _, lag in started]
        n_back = int(np.ceil(max([longest, *lags]) / orbit.period)) + 1
        for s, name in enumerate(names):
            for k in range(n_back + 1):
                happened = orbit.ends[s] - k * orbit.period
                if happened > begin + 1e-9 * orbit.period:
                    continue
                breaks.append(happened)
                for event, lag in clocks.get(model.segments[name].event, ()):
                    if happened + lag > begin + 1e-9 * orbit.period:
                        pending.append((happened + lag, event))
    if perturbation is None:
        history = orbit
    else:

        def history(t, side):
            return orbit(t, side) + perturbation

    start = orbit.first_state() if begin == orbit.start and perturbation is None else None
    motion = model.motion(
        parameters, history, mode, at=begin, start=start, echoes=ECHOES, pending=sorted(pending), max_events=2000
    )
    for t in breaks:
        motion._break_at(t)
    motion.breaks = [t for t in motion.breaks if t > begin + 1e-11]
    return motion


def check_period(model, orbit):
    """Return whether one period from the orbit's own past is the orbit."""
    fault, motion = _run(model, orbit, orbit.start, None)
    if fault:
        return Verdict(f"{fault}{_near_limit(model, orbit)}")
    deviation = _deviation(motion, orbit)
    allowed = ESTIMATES * orbit.error + FLOOR
    if deviation > allowed:
        # The integration apart has errors too: a finer one is to say the same.
        fault, motion = _run(model, orbit, orbit.start, None, accuracy=FINER)
        deviation = np.inf if fault else _deviation(motion, orbit)
        allowed *= max(1.0, _magnification(model, orbit))
    if allowed > SENSITIVE:
        return Verdict(TOO_SENSITIVE, deviation, allowed)
    return Verdict("" if deviation <= allowed else "deviates", deviation, allowed)


def _run(model, orbit, begin, perturbation, accuracy=1.0):
    """Return (fault, motion) of one period: what is wrong with its events, empty for nothing."""
    motion = start_motion(model, orbit, begin, perturbation)
    motion.accuracy = accuracy
    expected = [] if orbit.eventless else orbit.names
    late = begin + orbit.period * (1 + 1e-3)
    try:
        motion.run(late, n_events=len(expected) or None)
    except MotionError as error:
        return str(error), motion
    found = [name for name, _, _ in motion.events]
    for i, (said, true) in enumerate(zip(expected, found, strict=False)):
        if said != true:
            return f"'{true}' happens at t = {motion.events[i][1]:.10g} instead of '{said}'", motion
    if len(found) < len(expected):
        return f"'{expected[len(found)]}' does not happen", motion
    if len(found) > len(expected):
        return f"'{found[len(expected)]}' happens at t = {motion.events[len(expected)][1]:.10g}", motion
    return "", motion


def _near_limit(model, orbit):
    """Return ' (at the limit)' if a change of the past as small as the orbit's error mends its events."""
    rng = np.random.default_rng(1)
    for _ in range(4):
        change = rng.choice([-1.0, 1.0], len(model.states)) * orbit.sizes * (ESTIMATES * orbit.error + FLOOR)
        # The perturbed motion starts where it is on no surface, and ends a period later.
        fault, _ = _run_between(model, orbit, change)
        if not fault:
            return AT_LIMIT
    return ""


def _run_between(model, orbit, perturbation):
    begin, first = _middle(orbit)
    motion = start_motion(model, orbit, begin, perturbation)
    expected = [] if orbit.eventless else [*orbit.names[first:], *orbit.names[:first]]
    try:
        motion.run(begin + orbit.period)
    except MotionError as error:
        return str(error), motion
    return ("" if [name for name, _, _ in motion.events] == expected else "other events"), motion


def _middle(orbit):
    """Return the middle of the longest segment, and its number."""
    durations = np.diff(orbit.ends, prepend=orbit.start)
    longest = int(np.argmax(durations))
    return float(orbit.ends[longest] - 0.5 * durations[longest]), longest


def _deviation(motion, orbit):
    """Return the largest distance between a motion and the orbit, states at equal parts of segments, and times."""
    if orbit.eventless:
        ends, happened = np.array([orbit.start + orbit.period]), np.array([orbit.start + orbit.period])
    else:
        ends, happened = orbit.ends, np.array([t for _, t, _ in motion.events])
    sizes, worst = orbit.sizes, float(np.max(np.abs(happened - ends)) / orbit.period)
    before, start = orbit.start, orbit.start
    for s, (end, t) in enumerate(zip(ends, happened, strict=True)):
        for part in PLACES:
            side = -1 if part == 1.0 else 1
            off = motion(start + part * (t - start), side) - orbit(before + part * (end - before), side)
            worst = max(worst, float(np.max(np.abs(off) / sizes)))
        if not orbit.eventless:
            off = motion.afters[s] - orbit(end, 1)
            worst = max(worst, float(np.max(np.abs(off) / sizes)))
        before, start = end, t
    return worst


def _magnification(model, orbit):
    """Return how much larger a small change of the past becomes within a period, at most."""
    rng, worst = np.random.default_rng(2), 0.0
    begin, _ = _middle(orbit)
    try:
        plain = start_motion(model, orbit, begin).run(begin + orbit.period)
        for _ in range(3):
            change = rng.standard_normal(len(model.states)) * orbit.sizes * TINY
            moved = start_motion(model, orbit, begin, change).run(begin + orbit.period)
            times = begin + np.linspace(0.05, 1, 60) * orbit.period
            off = np.array([np.max(np.abs(moved(t) - plain(t)) / orbit.sizes) for t in times])
            # Between the times of an event in one motion and in the other they are far apart: those times are left out.
            worst = max(worst, float(np.sort(off)[-4]) / TINY)
    except MotionError:
        return 1.0
    return worst


def check_multiplier(model, orbit, multipliers, n_periods=10):
    """Return (claimed, measured, agrees) of the leading multiplier's modulus; None where nothing can be measured.

    Two motions on opposite sides of the orbit are followed; their distances after n periods obey a linear recurrence
    whose roots are the leading multipliers. In autonomous models 1 is a root too, of distances and not of their
    differences; it is among the multipliers of orbits without events, whose phase nothing else fixes.
    """
    claimed = np.array(sorted(multipliers, key=abs, reverse=True))
    autonomous = model.period is None
    if autonomous and orbit.eventless and len(claimed):
        claimed = np.delete(claimed, np.argmin(np.abs(claimed - 1)))
    if not len(claimed) or not 0.05 < abs(claimed[0]) < 20:
        return None
    n_periods = int(np.clip(np.log(1e-5) / np.log(min(abs(claimed[0]), 0.9)), 6, n_periods + 6))
    results = [_measure(model, orbit, n_periods, small, autonomous) for small in (SMALL, SMALL / 2)]
    if any(r is None for r in results):
        return None
    (first, far), (second, near) = results
    n = min(len(far), len(near))
    if np.any(np.abs(far[:n] - 2 * near[:n]) > LINEAR * far[:n]):
        # They go to different motions, on either side of a border near the orbit.
        return None
    if abs(first - second) > 0.3 * GROWTH_TOL * max(abs(first), 0.1):
        return None
    return abs(claimed[0]), first, abs(first - abs(claimed[0])) <= GROWTH_TOL * max(first, 0.1)


def _measure(model, orbit, n_periods, small, autonomous):
    """Return the largest modulus of the roots of the recurrence that distances obey, and these, period by period.

    None if they obey none.
    """
    begin, _ = _middle(orbit)
    rng = np.random.default_rng(3)
    change = rng.standard_normal(len(model.states)) * orbit.sizes * small
    try:
        end = begin + (n_periods + 1) * orbit.period
        above, below = (start_motion(model, orbit, begin, c).run(end) for c in (change, -change))
    except MotionError:
        return None
    if [e[0] for e in above.events] != [e[0] for e in below.events]:
        return None
    # Times farthest from events: the middles of the longest segments.
    durations = np.diff(orbit.ends, prepend=orbit.start)
    order = np.argsort(durations)[::-1][:4]
    places = np.concatenate([orbit.ends[s] - durations[s] * np.array([0.35, 0.5, 0.65]) for s in order])
    places = begin + np.mod(places - begin, orbit.period)
    times = [places + k * orbit.period for k in range(n_periods)]
    distances = np.array([np.concatenate([above(t) - below(t) for t in row]) for row in times])
    distances /= 2 * np.tile(orbit.sizes, len(places))
    if autonomous:
        distances = np.diff(distances, axis=0)
    norms = np.linalg.norm(distances, axis=1)
    good = norms > NOISE
    last = int(np.argmin(good)) if not good.all() else len(norms)
    if last < 4 or norms[:last].max() > LARGE:
        return None
    root = _largest_root(distances[:last])
    return None if root is None else (root, norms[:last])


def _largest_root(distances):
    """Return the largest modulus among the roots of the shortest recurrence that the distances obey, None if none does.

    d_n = c_1 d_(n-1) + .. + c_k d_(n-k), each n of weight one. It has to hold to RECURRENCE in the last of them too.
    """
    for order in (1, 2, 3, 4):
        for skip in range(len(distances) - order - 1):
            rows, right = [], []
            for i in range(skip + order, len(distances)):
                weight = 1.0 / np.linalg.norm(distances[i])
                rows.append(distances[i - order : i][::-1].T * weight)
                right.append(distances[i] * weight)
            left, right = np.concatenate(rows), np.concatenate(right)
            found, *_ = np.linalg.lstsq(left, right, rcond=None)
            if np.linalg.norm(left @ found - right) < RECURRENCE * np.sqrt(len(rows)) and len(rows) > 1:
                return float(np.max(np.abs(np.roots([1.0, *-found]))))
    return None
