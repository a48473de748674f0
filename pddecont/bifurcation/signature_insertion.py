"""Segments inserted where an orbit grazes.

At a grazing the orbit touches the surface of an event that its mode watches. Beyond, it crosses it: the segment is cut
at the touch, the mode that the event leads to is entered, and the way back to the old mode, if it is another one, is
inserted with it.

    soft   NC            becomes   NC, C, NC     the inserted C begins with duration zero
    hard   hop           becomes   hop, hop      the inserted reset begins with speed zero

Both signatures meet in one orbit; the new one is entered a little way inside.

References: di Bernardo, Budd, Champneys, Kowalczyk, Piecewise-smooth Dynamical Systems (2008), chapters 6-8; Dankowicz,
Schilder, Recipes for Continuation (2013), section 9.3.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.crossing_rates import find_crossing_rate
from pddecont.bifurcation.extended_system import ExtendedSystem
from pddecont.collocation import MeshRule
from pddecont.continuation import (
    CurvePoint,
    NewtonSettings,
    Solution,
    correct_component,
    find_tangent,
    solve_adaptively,
)
from pddecont.errors import ConvergenceError
from pddecont.model import Model, Segment, list_transitions
from pddecont.orbit import (
    Orbit,
    OrbitEvaluation,
    PeriodicOrbitSystem,
    SegmentSpan,
    find_approaches,
    find_event_profiles,
    resegment,
)

Array = NDArray[np.float64]
# How long an inserted segment first is, in periods: short, but well above rounding.
INSIDE = 1e-3
# Approaches as close as the closest to this, relative to the event function's size, touch at once.
SAME = 1e-8
# Length of the step along a branch over which the rate of crossing is compared.
STEP = 1e-4


@dataclass(frozen=True)
class Touch:
    """Where an orbit touches an event's surface: its segment and time, the segment that begins to end there.

    ``back`` are the segments of the way back to its mode.
    """

    s: int
    time: float
    touched: Segment
    back: tuple[Segment, ...]


def find_way_back(model: Model, segment: Segment, touched: Segment) -> list[Segment] | None:
    """Return the segments from the mode that ``touched`` leads to back to the mode of ``segment``.

    It is the shortest way, by the same event before others; None if there is none, empty if it is the same mode.
    """
    paths: deque[tuple[str, list[Segment]]] = deque([(touched.to, [])])
    seen = {touched.to}
    while paths:
        mode, path = paths.popleft()
        if mode == segment.mode:
            return path
        leaving = sorted(list_transitions(model, mode).segments, key=lambda s: s.event != touched.event)
        for step in leaving:
            if step.to not in seen or step.to == segment.mode:
                seen.add(step.to)
                paths.append((step.to, [*path, step]))
    return None


def find_touches(orbit: Orbit) -> list[Touch]:
    """Return all touches of a grazing orbit in order of time: the closest approach and all as close to rounding.

    Raises
    ------
    ConvergenceError
        If nothing is touched, or no segments lead back.
    """
    found = find_approaches(orbit)
    if not found:
        raise ConvergenceError("no event is touched here")
    sizes = {name: float(np.max(np.abs(p.values))) for name, p in find_event_profiles(orbit).items()}
    closest = max(a.gap / sizes[a.event] for a in found)
    signature, model, result = orbit.signature, orbit.numeric.model, []
    for a in sorted(found, key=lambda a: a.extremum.time):
        if a.gap / sizes[a.event] < closest - SAME:
            continue
        s = a.extremum.segment
        here = signature.segments[s]
        direction = next(w.direction for w in signature.list_watched_events(s) if w.event == a.event)
        touched = list_transitions(model, here.mode).surfaces[a.event, direction]
        back = find_way_back(model, here, touched)
        if back is None:
            raise ConvergenceError(f"after event '{a.event}' in mode '{here.mode}' no segment leads back to that mode")
        result.append(Touch(s, a.extremum.time, touched, tuple(back)))
    return result


def enter_signature(at: OrbitEvaluation, rule: MeshRule) -> CurvePoint[OrbitEvaluation]:
    """Return the first orbit with the segments inserted that a grazing orbit needs.

    Its direction leads away from the old signature.

    Raises
    ------
    ConvergenceError
        If there is none.
    """
    fixed = at.orbit.with_free(())
    touches, ends = find_touches(at.orbit), fixed.event_times
    width = INSIDE * ends[-1]
    spans: list[SegmentSpan] = []
    where = -1
    for s, here in enumerate(fixed.signature.segments):
        begin = ends[s]
        for touch in (t for t in touches if t.s == s):
            half = np.linspace(-0.5, 0.5, len(touch.back) + 1)
            cuts = touch.time + width * half if touch.back else np.array([touch.time])
            where = len(spans) if where < 0 else where
            back = [SegmentSpan(b, cuts[i], cuts[i + 1]) for i, b in enumerate(touch.back)]
            spans += [SegmentSpan(touch.touched, begin, cuts[0]), *back]
            begin = cuts[-1]
        if here.event:
            spans.append(SegmentSpan(here, begin, ends[s + 1]))
        else:
            # The orbit has met no event so far: it now begins where the last touch lets it go.
            spans[0] = SegmentSpan(spans[0].segment, begin - ends[-1], spans[0].end)
    guess = resegment(fixed, spans, rule, fixed.problem.n_periods).with_free(at.orbit.problem.free)
    system = PeriodicOrbitSystem(guess.problem, at.system.sizes, rule)
    first = min(touches, key=lambda t: t.s)
    return _begin_soft(system, guess, where) if first.back else _begin_hard(system, guess, where)


def _begin_soft(system: PeriodicOrbitSystem, guess: Orbit, where: int) -> CurvePoint[OrbitEvaluation]:
    """Return the first orbit inside the new signature, at a small duration of the inserted segment."""
    s = where + 1
    found = set_duration(system, guess.x, s, float(guess.durations[s]))
    if np.any(found.at.orbit.durations <= 0.0):
        raise ConvergenceError("the orbit of the longer signature has a segment of negative duration")
    towards = np.zeros(len(found.x))
    towards[found.at.orbit.problem.unknowns.duration(s)] = 1.0
    return replace(found, solution=None, direction=find_tangent(found.at, found.system.scaling, towards))


def _begin_hard(system: PeriodicOrbitSystem, guess: Orbit, where: int) -> CurvePoint[OrbitEvaluation]:
    """Return the grazing orbit in the new signature, with the direction in which the impact's speed grows.

    A hard impact of speed zero leaves the grazing orbit a solution of the new equations.
    """
    at, scaling = system.at(guess.x), system.scaling
    anywhere = np.random.default_rng(1).standard_normal(len(guess.x)) * scaling.scale
    direction = find_tangent(at, scaling, anywhere)
    beside = (Orbit(guess.problem, guess.x + k * STEP * direction) for k in (-1.0, 1.0))
    before, after = (find_crossing_rate(orbit, where) for orbit in beside)
    return CurvePoint(system, at, None, direction if after > before else -direction)


def set_duration(
    system: PeriodicOrbitSystem | ExtendedSystem, guess: Array, s: int, duration: float
) -> CurvePoint[Any]:
    """Return the orbit near ``guess`` whose segment ``s`` has ``duration``, on a mesh that is adequate for it.

    Raises
    ------
    ConvergenceError
        If there is none to be found.
    """

    def solve(on_mesh: Any, x: Array, _: list[Array]) -> Solution[Any]:
        return correct_component(on_mesh, x, on_mesh.problem.unknowns.duration(s), duration, NewtonSettings())

    found, solution = solve_adaptively(system, guess, solve)
    return CurvePoint(found, solution.at, solution)
