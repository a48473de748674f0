"""The signature changes: segments inserted where an orbit grazes, removed where one vanishes (design section 5.4).

At a grazing the orbit touches the surface of an event that its mode watches. Beyond, it crosses it: the segment is cut at the
touch, the mode that the event leads to is entered, and the way back to the old mode, if it is another one, is inserted with it.

    soft   NC            becomes   NC, C, NC     the inserted C begins with duration zero
    hard   hop           becomes   hop, hop      the inserted reset begins with speed zero

At a vanishing segment the same is read backwards, so a point where a segment vanishes is a grazing of the shorter signature, and
is solved as one. Both signatures meet in one orbit; the new one is entered a little way inside.

References: di Bernardo, Budd, Champneys, Kowalczyk, Piecewise-smooth Dynamical Systems (2008), chapters 6-8; Dankowicz, Schilder,
Recipes for Continuation (2013), section 9.3.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.conditioned import SpecialCurve, solve_special
from pddecont.bifurcation.grazing import graze_at
from pddecont.bifurcation.tangency import MEETS, rate
from pddecont.continuation.arclength import correct_at, tangent
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.settling import settled
from pddecont.errors import ConvergenceError
from pddecont.model.system import Model, Segment
from pddecont.orbit.admissibility import approaches, event_profiles, watched_events
from pddecont.orbit.curve import Curve
from pddecont.orbit.meshing import MeshRule
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.orbit.reshape import Part, reshape

Array = NDArray[np.float64]
INSIDE = 1e-3
SAME = 1e-8
MEETING = 1e-9
SHRINK = 0.3
NOTHING = 1e-5
STEP = 1e-4


@dataclass(frozen=True, eq=False)
class Entered:
    """The first orbit of a new signature: its curve, unknowns, and the direction that leads away from the old signature."""

    curve: Curve
    x: Array
    tangent: Array


def way_back(model: Model, segment: Segment, touched: Segment) -> list[Segment] | None:
    """Return the segments from the mode that ``touched`` leads to back to the mode of ``segment``.

    It is the shortest way, by the same event before others; None if there is none, empty if it is the same mode.
    """
    paths: deque[tuple[str, list[Segment]]] = deque([(touched.to, [])])
    seen = {touched.to}
    while paths:
        mode, path = paths.popleft()
        if mode == segment.mode:
            return path
        leaving = sorted((s for s in model.segments.values() if s.mode == mode), key=lambda s: s.event != touched.event)
        for step in leaving:
            if step.to not in seen or step.to == segment.mode:
                seen.add(step.to)
                paths.append((step.to, [*path, step]))
    return None


@dataclass(frozen=True)
class Touch:
    """Where an orbit touches an event's surface: its segment and time, the segment that begins to end there, and the way back."""

    s: int
    time: float
    touched: Segment
    back: tuple[Segment, ...]


def touches(problem: OrbitProblem, x: Array) -> list[Touch]:
    """Return all touches of a grazing orbit in order of time: the closest approach and all that are as close to rounding."""
    profiles = event_profiles(problem, x)
    found = approaches(problem, profiles)
    if not found:
        raise ConvergenceError("no event is touched here")
    sizes = {name: float(np.max(np.abs(p.values))) for name, p in profiles.items()}
    closest = max(height / sizes[event] for height, event, _ in found)
    model, result = problem.numeric.model, []
    for height, event, extremum in sorted(found, key=lambda f: f[2].time):
        if height / sizes[event] < closest - SAME:
            continue
        here = problem.segments[extremum.segment]
        direction = next(d for e, d, _ in watched_events(problem, extremum.segment) if e == event)
        touched = next(s for s in model.segments.values() if (s.mode, s.event, s.direction) == (here.mode, event, direction))
        back = way_back(model, here, touched)
        if back is None:
            raise ConvergenceError(f"after event '{event}' in mode '{here.mode}' no segment leads back to that mode")
        result.append(Touch(extremum.segment, extremum.time, touched, tuple(back)))
    return result


def enter(curve: Curve, x: Array, rule: MeshRule) -> Entered:
    """Return the orbit with the segments inserted that the grazing orbit ``x`` needs; raise ConvergenceError if there is none."""
    problem = curve.problem
    found = touches(problem, x)
    fixed, at = problem.with_free(x, ())
    ends = np.concatenate([[0.0], np.cumsum(fixed.layout.split(at)[1])])
    width = INSIDE * ends[-1]
    parts: list[Part] = []
    where = -1
    for s, here in enumerate(problem.segments):
        begin = ends[s]
        for touch in (t for t in found if t.s == s):
            cuts = touch.time + width * np.linspace(-0.5, 0.5, len(touch.back) + 1) if touch.back else np.array([touch.time])
            where = len(parts) if where < 0 else where
            parts += [Part(touch.touched, begin, cuts[0]), *(Part(b, cuts[i], cuts[i + 1]) for i, b in enumerate(touch.back))]
            begin = cuts[-1]
        if here.event:
            parts.append(Part(here, begin, ends[s + 1]))
        else:
            # The orbit has met no event so far: it now begins where the last touch lets it go.
            parts[0] = Part(parts[0].segment, begin - ends[-1], parts[0].end)
    entered, guess = reshape(fixed, at, parts, rule, problem.n_periods)
    first = next(t for t in found if t.s == min(t.s for t in found))
    return _begin(curve, entered, guess, rule, where, soft=bool(first.back))


def _begin(curve: Curve, problem: OrbitProblem, guess: Array, rule: MeshRule, where: int, *, soft: bool) -> Entered:
    """Return the first orbit inside the new signature: a soft one at a small duration of the inserted segment."""
    free = curve.problem.free
    problem, guess = problem.with_free(guess, free)
    made = Curve(problem, curve.sizes, rule)
    if soft:
        made, solution = _with_duration(made, guess, where + 1, guess[place_of(made, where + 1)])
        if np.any(solution.x[made.problem.layout.durations] <= 0.0):
            raise ConvergenceError("the orbit of the longer signature has a segment of negative duration")
        towards = np.zeros(len(solution.x))
        towards[place_of(made, where + 1)] = 1.0
        return Entered(made, solution.x, tangent(made, solution.x, made.metric(), towards))
    # A hard impact of speed zero leaves the grazing orbit a solution of the new equations; go to where the speed grows.
    metric = made.metric()
    direction = tangent(made, guess, metric, np.random.default_rng(1).standard_normal(len(guess)) * metric.scale)
    before, after = (rate(problem, guess + k * STEP * direction, where) for k in (-1.0, 1.0))
    return Entered(made, guess, direction if after > before else -direction)


def place_of(curve: Curve | SpecialCurve, s: int) -> int:
    """Return the place of the duration of segment ``s`` among the unknowns."""
    return curve.problem.layout.durations.start + s


Followable = TypeVar("Followable", Curve, SpecialCurve)


def _with_duration(curve: Followable, guess: Array, s: int, duration: float) -> tuple[Followable, Solution]:
    """Return the orbit near ``guess`` whose segment ``s`` has ``duration``, on a mesh that suits it."""
    return settled(curve, guess, lambda c, g: correct_at(c, g, place_of(c, s), duration, c.metric(), NewtonSettings()))


def leave(curve: Curve, x: Array, rule: MeshRule, s: int) -> tuple[OrbitProblem, Array]:
    """Return the orbit without what vanishes at the end of segment ``s``, as a guess.

    A soft segment s + 1 of small duration goes with both its events; a hard impact of small speed goes with its reset.
    """
    problem, at = curve.problem.with_free(x, ())
    segments = problem.segments
    S = len(segments)
    ends = np.concatenate([[0.0], np.cumsum(problem.layout.split(at)[1])])
    period = ends[-1]
    here, after = segments[s], segments[(s + 1) % S]
    n_merged = 2 if after.mode == here.mode else 3
    if n_merged == 3 and segments[(s + 2) % S].mode != here.mode:
        raise ConvergenceError(f"mode '{after.mode}' vanishes, but the orbit does not go on in mode '{here.mode}'")
    if n_merged > S:
        alone = eventless(here.mode)
        return reshape(problem, at, [Part(alone, ends[s + 1] - period, ends[s + 1])], rule, problem.n_periods)
    order = [(s + k) % S for k in range(S)]
    begin = np.concatenate([[0.0], np.cumsum(np.diff(ends)[order])]) + ends[s]
    merged = Part(segments[order[n_merged - 1]], begin[0], begin[n_merged])
    rest = [Part(segments[order[k]], begin[k], begin[k + 1]) for k in range(n_merged, S)]
    return reshape(problem, at, [merged, *rest], rule, problem.n_periods)


@dataclass(frozen=True, eq=False)
class Vanished:
    """Where a segment's duration reaches zero: the special orbit, and whether it is one of the shorter signature."""

    curve: Curve
    solution: Solution
    note: str
    shorter: bool


def vanish(curve: Curve, x: Array, rule: MeshRule) -> Vanished:
    """Return the point at which the shortest segment of the orbit ``x`` vanishes as the branch goes on.

    Between two crossings of one event the segment dies in a grazing of the orbit without it, solved as such; between two different
    events it ends where both happen at once, reached to a duration of ``MEETING`` periods. Raises ConvergenceError if it cannot be
    reached.
    """
    problem = curve.problem
    s = int(np.argmin(x[problem.layout.durations]))
    period = problem.period(x)
    before = problem.segments[s - 1]
    same = before.event == problem.segments[s].event
    last = (INSIDE if same else MEETING) * period
    while x[place_of(curve, s)] > last:
        curve, solution = _with_duration(curve, x, s, max(last, SHRINK * x[place_of(curve, s)]))
        x = solution.x
    name = problem.segments[s].name
    if not same:
        note = f"{before.event}{MEETS}{problem.segments[s].event}"
        curve, solution = _with_duration(curve, x, s, last)
        return Vanished(curve, solution, note, False)
    shorter, guess = without_segment(curve, x, rule, (s - 1) % len(problem.segments))
    condition = graze_at(shorter.problem, guess)
    if condition is None:
        raise ConvergenceError(f"segment {name} vanishes, but the orbit without it touches nothing")
    special, solution = solve_special(shorter, guess, condition)
    return Vanished(special.curve, solution, f"{name} vanishes", True)


def shrink(curve: SpecialCurve, x: Array) -> tuple[SpecialCurve, Solution, str]:
    """Return the orbit of a curve in two parameters whose shortest segment has ``NOTHING`` periods left, and that segment's name.

    What is left of it changes the parameters by its square where the segment lies between two crossings of one event.
    """
    problem = curve.problem
    s, last = int(np.argmin(x[problem.layout.durations])), NOTHING * problem.period(x)
    while True:
        curve, solution = _with_duration(curve, x, s, max(last, SHRINK * x[place_of(curve, s)]))
        x = solution.x
        if x[place_of(curve, s)] <= last * (1.0 + 1e-9):
            return curve, solution, problem.segments[s].name


def without_segment(curve: Curve, x: Array, rule: MeshRule, s: int) -> tuple[Curve, Array]:
    """Return the curve of orbits without what vanishes at the end of segment ``s``, and ``x`` in its unknowns."""
    problem, guess = leave(curve, x, rule, s)
    problem, guess = problem.with_free(guess, curve.problem.free)
    return Curve(problem, curve.sizes, rule), guess


def away(curve: Curve, x: Array) -> Array:
    """Return the tangent at a grazing orbit along which it comes free."""
    towards = np.zeros(len(x))
    towards[curve.problem.layout.free.start] = 1.0
    direction = tangent(curve, x, curve.metric(), towards)
    condition = graze_at(curve.problem, x)
    assert condition is not None
    low, high = (condition.value(curve, x + k * STEP * direction) for k in (-1.0, 1.0))
    sign = 1.0 if condition.is_max else -1.0
    return direction if sign * (high - low) < 0.0 else -direction
