"""Where a sampled motion meets the events of a signature: at zeros of their functions, and where its states jump."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.errors import SignatureError
from pddecont.model import WAYS, Segment
from pddecont.orbit.sampled_motion import AT_EDGE, SampledMotion
from pddecont.simulate import make_past_plan, read_values

# Periods back up to which integrals over the past are taken piece by piece.
MOST_PERIODS = 20

Array = NDArray[np.float64]
# States jump at an event where its function is no farther from zero than this part of its size: rows are rough.
NEAR = 0.1
# Times that a message lists.
MAX_TOLD = 5


@dataclass(frozen=True)
class Candidate:
    """A time at which a segment may end, and how much speaks against it (0: its event function crosses zero there)."""

    t: float
    miss: float


@dataclass(frozen=True, eq=False)
class EventSearch:
    """Looks for the events of segments along a motion at parameters ``p``."""

    numeric: NumericModel
    p: Array
    motion: SampledMotion
    _found: dict[str, tuple[Candidate, ...]] = field(default_factory=dict, init=False, repr=False)

    @property
    def jumps(self) -> Array:
        """The times at which states jump, from the first edge on for one period."""
        return np.zeros(0) if self.motion.closed else self.motion.edges[1:]

    def evaluate(self, event: str, t: Array, curve: NDArray[np.intp]) -> Array:
        """Return an event function at times on curves of the motion, shape (n_times,)."""
        motion, x = self.motion, self.motion.evaluate(t, curve=curve)
        reach = np.arange(-MOST_PERIODS, 2)[:, None] * motion.period
        edges = np.unique(motion.edges + reach)
        plan = make_past_plan(self.numeric.model)

        def read(times: Array, order: int) -> Array:
            return motion.evaluate(times, order).T

        xd = read_values(self.numeric, plan, self.p, t, x.T, read, edges)
        return np.asarray(self.numeric.event(event).value(t, x.T, xd, self.p)[0])

    def list_candidates(self, segment: Segment, signature: Sequence[Segment]) -> tuple[Candidate, ...]:
        """Return where ``segment`` may end, in order of time, within the period that begins at the first edge."""
        if segment.name not in self._found:
            # A chain of delayed events may close on itself: what is not known yet has no candidates.
            self._found[segment.name] = ()
            event = self.numeric.model.events[segment.event]
            found = self._list_crossings(segment) if event.function is not None else self._shift(segment, signature)
            self._found[segment.name] = tuple(sorted(found, key=lambda c: c.t))
        return self._found[segment.name]

    def _list_crossings(self, segment: Segment) -> list[Candidate]:
        """Return where an event function crosses zero, and the jumps of states near which it is small."""
        motion, found, ends, size = self.motion, [], [], 0.0
        for k, rows in enumerate(motion.rows):
            begin, end = motion.edges[k], motion.edges[k + 1]
            t = np.unique(np.concatenate([[begin], rows[(rows > begin) & (rows < end)], [end]]))
            h = self.evaluate(segment.event, t, np.full(len(t), k))
            size = max(size, float(np.max(np.abs(h[np.isfinite(h)]), initial=0.0)))
            ends.append(float(h[-1]))
            for i in _list_changes(h, segment.direction):
                at_jump = not motion.closed and i == len(t) - 2
                zero = end if at_jump else self._wrap(self.find_end(segment, k, float(t[i]), float(t[i + 1])))
                found.append(Candidate(float(zero), 0.0))
        known = {c.t for c in found}
        jumps = zip(self.jumps.tolist(), ends, strict=not motion.closed)
        return found + [
            Candidate(t, abs(h) / (size or 1.0)) for t, h in jumps if t not in known and abs(h) <= NEAR * size
        ]

    def find_end(self, segment: Segment, k: int, low: float, high: float) -> float:
        """Return where a segment along curve number ``k`` ends between two times.

        That is where its event function crosses zero, or the one at which it is nearer to zero; halfway for a delayed
        event.
        """
        if self.numeric.model.events[segment.event].function is None:
            return 0.5 * (low + high)

        def value(t: float) -> float:
            return float(self.evaluate(segment.event, np.array([t]), np.array([k]))[0])

        signs = value(low), value(high)
        if signs[0] * signs[1] < 0.0:
            return float(scipy.optimize.brentq(value, low, high))
        return low if abs(signs[0]) < abs(signs[1]) else high

    def find_next_row(self, t: float) -> float:
        """Return the time of the first row after a time."""
        motion = self.motion
        rows = np.unique(np.concatenate(motion.rows))
        later = rows[rows > t + AT_EDGE * motion.period]
        return float(later[0]) if len(later) else float(motion.edges[-1])

    def _shift(self, segment: Segment, signature: Sequence[Segment]) -> list[Candidate]:
        """Return where a delayed event comes after those that start it; at a jump of states if one is near."""
        model, motion = self.numeric.model, self.motion
        event = model.events[segment.event]
        sources = {s.name: s for s in signature if model.events[s.event].starts(event)}
        delay = float(self.numeric.event_delay(event.name).value(self.p)[0])
        found = []
        for source in sources.values():
            for c in self.list_candidates(source, signature):
                t = self._wrap(c.t + delay)
                away = np.abs((self.jumps - t + 0.5 * motion.period) % motion.period - 0.5 * motion.period)
                nearest = int(np.argmin(away)) if np.any(away <= self._spacing()) else None
                at, miss = (t, 0.0) if nearest is None else (float(self.jumps[nearest]), float(away[nearest]))
                found.append(Candidate(at, c.miss + miss / motion.period))
        return found

    def _wrap(self, t: float) -> float:
        """Return a time less whole periods: after the first edge, which stands for the last, up to the last."""
        motion = self.motion
        within = float((t - motion.edges[0]) % motion.period)
        return float(motion.edges[0]) + within + motion.period * (within <= AT_EDGE * motion.period)

    def _spacing(self) -> float:
        return max(float(np.max(np.diff(rows))) for rows in self.motion.rows)


def _list_changes(h: Array, direction: str) -> list[int]:
    """Return the places before which a function has one sign and after which the other, in a segment's direction."""
    below = h < 0.0
    finite = np.isfinite(h)
    ways = {"rising": below[:-1] & ~below[1:], "falling": ~below[:-1] & below[1:]}
    changes = np.any([ways[way] for way in WAYS[direction]], axis=0) & finite[:-1] & finite[1:]
    return [int(i) for i in np.flatnonzero(changes)]


@dataclass(frozen=True)
class _Walk:
    """Where the segments of a signature end, from number ``first`` on; ``miss`` as in candidates."""

    first: int
    ends: tuple[float, ...]
    miss: float


def find_segment_ends(search: EventSearch, signature: Sequence[Segment]) -> Array:
    """Return where a motion begins to run through a signature and where each segment ends, shape (n_segments + 1,).

    The motion may begin anywhere: the signature is tried from each of its segments on, and what fits best is taken.

    Raises
    ------
    SignatureError
        If the motion does not run through the signature.
    """
    walks = [walk for first in range(len(signature)) if (walk := _walk(search, signature, first)) is not None]
    if not walks:
        raise SignatureError(_explain_misfit(search, signature))
    best, n = min(walks, key=lambda walk: walk.miss), len(signature)
    times = [best.ends[(j - best.first) % n] for j in range(-1, n)]
    for j in range(1, n + 1):
        times[j] += search.motion.period * (times[j] <= times[j - 1])
    return np.array(times)


def _walk(search: EventSearch, signature: Sequence[Segment], first: int) -> _Walk | None:
    """Return the times of a signature's events in turn, beginning with number ``first``, or None if it does not fit.

    No segment goes on over a jump, and nothing is left when the period is over.
    """
    motion, n = search.motion, len(signature)
    end, room = motion.edges[-1], AT_EDGE * motion.period
    t, miss = float(motion.edges[0]), 0.0
    ends: list[float] = []
    for k in range(n + 1):
        segment, before = signature[(first + k) % n], signature[(first + k - 1) % n]
        again = segment.event == before.event and (k > 0 or not motion.closed)
        # Just after an event its function is zero, to the digits that rows have.
        least = search.find_next_row(t) if again else t + room
        found = next((c for c in search.list_candidates(segment, signature) if c.t > least), None)
        jump = min(search.jumps[search.jumps > t + room], default=end)
        if k == n:
            is_over = found is None and (motion.closed or end - t <= room)
            return _Walk(first, tuple(ends), miss) if is_over else None
        if found is None or found.t > jump + room:
            return None
        t, miss = found.t, miss + found.miss
        ends.append(t)
    raise AssertionError("the last turn returns")


def _explain_misfit(search: EventSearch, signature: Sequence[Segment]) -> str:
    """Return in words why a motion does not run through a signature: where its events are."""
    motion = search.motion

    def list_times(times: Iterable[float]) -> str:
        # The beginning of the period stands for its end.
        within = sorted(t - motion.period * (t >= motion.edges[-1]) for t in times)
        return ", ".join(f"{t:.6g}" for t in within[:MAX_TOLD]) + (", .." if len(within) > MAX_TOLD else "")

    told = []
    for segment in {s.name: s for s in signature}.values():
        found = search.list_candidates(segment, signature)
        where = f"may end at t = {list_times(c.t for c in found)}" if found else "ends nowhere"
        told.append(f"'{segment.name}' {where}")
    if len(search.jumps):
        told.append(f"states jump at t = {list_times(search.jumps)}")
    return (
        f"the rows do not run through the signature [{', '.join(s.name for s in signature)}] once: {'; '.join(told)}. "
        "The last row closes the period, and a jump has two rows at one time; a column 'segment' says where segments "
        "end"
    )
