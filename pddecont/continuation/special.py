"""Special points on a step of a branch: test functions, a census of whole numbers, and what happened between two points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pddecont.continuation.ending import End
from pddecont.continuation.locate import Chord, Located
from pddecont.errors import ConvergenceError

MAX_CUTS = 10
SHORT = 1e-6


@dataclass(frozen=True)
class TestFunction:
    """A function along the branch whose zero is a special point of ``kind``; ``stops`` if the branch ends there, with ``end``.

    ``note`` says more of the point. ``meeting`` finds the point itself between two orbits with a change of sign, or None: where a branch
    meets another one, no orbit between the two can be found on the way and no census can be trusted.
    """

    __test__ = False
    kind: str
    value: Callable[[Located], float]
    stops: bool = False
    note: str = ""
    end: End = End.SPECIAL
    meeting: Callable[[Located, Located], Located | None] | None = None


Counts = tuple[int, ...]


@dataclass(frozen=True)
class Census:
    """Whole numbers that change only at special points, such as how many multipliers lie outside the unit circle.

    ``explain(before, after)`` returns the test functions whose zeros account for a change, or None if several changes have come
    together and the step must be cut.
    """

    count: Callable[[Located], Counts]
    explain: Callable[[Counts, Counts], Sequence[TestFunction] | None]


@dataclass(frozen=True)
class Watch:
    """What is watched along a branch; ``objection`` says why a point is none of the problem's solutions, empty if it is one."""

    tests: Sequence[TestFunction] = ()
    census: Census | None = None
    objection: Callable[[Located], str] = lambda _: ""


@dataclass(frozen=True)
class Seen:
    """What the watch says of a point."""

    values: tuple[float, ...]
    counts: Counts
    objection: str


def look(point: Located, watch: Watch) -> Seen:
    """Return what the watch says of a point."""
    counts = watch.census.count(point) if watch.census else ()
    return Seen(tuple(test.value(point) for test in watch.tests), counts, watch.objection(point))


@dataclass(frozen=True, eq=False)
class Found:
    """A special point at a fraction of a step."""

    test: TestFunction
    point: Located
    fraction: float


def specials_between(chord: Chord, watch: Watch, before: Seen, after: Seen, from_: float) -> tuple[list[Found], int]:
    """Return the special points on a step in order, and the number of changes in the census that none of them explains.

    Where two fall together the one that ends the branch comes first.

    Those before the fraction ``from_`` are the point that the branch starts from.
    """
    found = []
    for test, f0, f1 in zip(watch.tests, before.values, after.values, strict=True):
        if f0 * f1 < 0.0 or (f1 == 0.0 and f0 != 0.0):
            found += _zero(chord, test, 0.0, 1.0, f0, f1)
    found, lost = [f for f in found if f.fraction >= from_], 0
    if watch.census is not None and not any(f.test.meeting for f in found):
        # What lies beyond a point that ends the branch counts for nothing, and on it a multiplier may be infinite of either sign.
        last = min((f.fraction * (1.0 - SHORT) for f in found if f.test.stops), default=1.0)
        counts = after.counts if last == 1.0 else watch.census.count(chord.at(last))
        counted = _counted(chord, watch.census, 0.0, last, before.counts, counts, MAX_CUTS)
        found += [f for f in counted if f is not None]
        # At the start of a branch the special point that it comes from may still show.
        lost = 0 if from_ else len([f for f in counted if f is None])
    order = sorted((f for f in found if f.fraction >= from_), key=lambda f: (round(f.fraction, 6), not f.test.stops, f.fraction))
    return order, lost


def _zero(chord: Chord, test: TestFunction, low: float, high: float, f_low: float, f_high: float) -> list[Found]:
    if test.meeting is not None:
        met = test.meeting(chord.at(low), chord.at(high))
        return [] if met is None else [Found(test, met, low + (high - low) * f_low / (f_low - f_high))]
    fraction = chord.zero(test.value, low, high, f_low, f_high)
    return [] if fraction is None else [Found(test, chord.at(fraction), fraction)]


def _counted(chord: Chord, census: Census, low: float, high: float, before: Counts, after: Counts, cuts: int) -> list[Found | None]:
    """Return the special points that account for a change of the census, cutting the step where several come together.

    None stands for a change that could not be explained.
    """
    if before == after:
        return []
    tests = census.explain(before, after)
    if tests is not None:
        ends = [(test.value(chord.at(low)), test.value(chord.at(high))) for test in tests]
        # A test function may not exist all along: no real multiplier at one end, say. Then the step is cut too.
        if all(f_low * f_high <= 0.0 for f_low, f_high in ends):
            result: list[Found | None] = []
            for test, (f_low, f_high) in zip(tests, ends, strict=True):
                result += _zero(chord, test, low, high, f_low, f_high) or [None]
            return result
    if cuts == 0:
        return [None]
    middle = 0.5 * (low + high)
    try:
        between = census.count(chord.at(middle))
    except ConvergenceError:
        return [None]
    return [*_counted(chord, census, low, middle, before, between, cuts - 1),
            *_counted(chord, census, middle, high, between, after, cuts - 1)]  # fmt: skip
