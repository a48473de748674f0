"""From a table of times and states to a cycle through the segments of a signature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.errors import SignatureError
from pddecont.model import Model, check_signature
from pddecont.orbit.event_search import EventSearch, find_segment_ends
from pddecont.orbit.motion_table import MAX_SHOWN, MotionTable
from pddecont.orbit.sampled_motion import SampledMotion, close_rows, join_rows

Array = NDArray[np.float64]
# Two rows at one time are a jump if they differ by this part of a state's range; less is what few digits make.
JUMP = 1e-2
# The last row closes the period if it differs from the first by no more than this part of a state's range.
CLOSED = 0.1
# Segments that a message lists.
MAX_TOLD = 20
# Rows of a forced model may span whole forcing periods up to this part of them.
SPAN = 1e-2


@dataclass(frozen=True, eq=False)
class SampledCycle:
    """One period of a motion in a table; what it says is what :class:`pddecont.simulate.Cycle` says."""

    signature: tuple[str, ...]
    times: Array
    n_periods: int
    mode: str
    motion: SampledMotion

    def evaluate(self, segment: int, t: Array) -> Array:
        """Return the states at times ``t`` in a segment, shape (n_times, n_states)."""
        return self.motion.evaluate_between(t, self.times[segment], self.times[segment + 1])


def find_cycle(
    numeric: NumericModel, p: Array, table: MotionTable, signature: Sequence[str] = (), mode: str | None = None
) -> SampledCycle:
    """Return the cycle that a table holds one period of, at parameters ``p``.

    ``signature`` is what it runs through, if the table does not say so; ``mode`` that of a motion without events.

    Raises
    ------
    SignatureError
        If the table holds no such cycle.
    """
    model, n_periods = numeric.model, 1
    if model.forced:
        table, n_periods = _fit_forcing(table, float(numeric.period.value(p)[0]))
    blocks = _split_blocks(table)
    names = _find_signature(model, table, blocks, tuple(signature), mode)
    if not names:
        only = mode or next(iter(model.modes))
        motion = _close(table)
        return SampledCycle((), motion.edges, n_periods, only, motion)
    check_signature(model, names)
    if len(blocks) > 1 and table.segment is not None:
        times, motion = _cut_at_blocks(numeric, p, table, blocks, names)
    else:
        times, motion = _cut_at_events(numeric, p, table, names)
    return SampledCycle(names, times, n_periods, model.segments[names[0]].mode, motion)


def _fit_forcing(table: MotionTable, period: float) -> tuple[MotionTable, int]:
    """Return the table stretched to whole periods of the forcing, and how many these are."""
    span = float(table.t[-1] - table.t[0])
    n = max(1, round(span / period))
    if abs(span - n * period) > SPAN * period:
        raise SignatureError(
            f"the rows span {span / period:.4g} periods of the forcing ({period:.6g}), from t = {table.t[0]:.6g} to "
            f"{table.t[-1]:.6g}; expected whole periods: the last row closes the period, and the forcing is that of "
            "the run's parameters"
        )
    return replace(table, t=table.t[0] + (table.t - table.t[0]) * (n * period / span)), n


def _find_jumps(table: MotionTable) -> list[int]:
    """Return the rows before which states jump: the time is that of the row above, the states are others."""
    swing = np.ptp(table.x, axis=0)
    differ = np.any(np.abs(np.diff(table.x, axis=0)) > JUMP * swing, axis=1)
    return [int(i) + 1 for i in np.flatnonzero((np.diff(table.t) == 0.0) & differ)]


def _find_gap(table: MotionTable) -> float:
    """Return how far the last row is from the first, relative to the range of the state that differs most."""
    swing = np.ptp(table.x, axis=0)
    return float(np.max(np.abs(table.x[-1] - table.x[0]) / np.where(swing > 0.0, swing, 1.0)))


def _close(table: MotionTable) -> SampledMotion:
    """Return the motion of a table without events."""
    jumps, gap = _find_jumps(table), _find_gap(table)
    if jumps:
        raise SignatureError(
            f"states jump at t = {table.t[jumps[0]]:.6g} (line {table.line[jumps[0]]}), and a motion without events "
            "has no jumps"
        )
    if gap > CLOSED:
        raise SignatureError(
            f"the last row (t = {table.t[-1]:.6g}) differs from the first by {gap:.2g} of a state's range; expected "
            "the first row's states again, a period later"
        )
    return close_rows(table.t, table.x)


def _cut_at_events(
    numeric: NumericModel, p: Array, table: MotionTable, names: tuple[str, ...]
) -> tuple[Array, SampledMotion]:
    """Return where segments begin and end, by their events, and the motion.

    What differs between the last row and the first is a jump, or what rows are rough by: both are tried.
    """
    segments = [numeric.model.segments[name] for name in names]
    jumps, gap = _find_jumps(table), _find_gap(table)
    motions = [_join_at_jumps(table, jumps, True)] if gap > JUMP else []
    if gap <= CLOSED:
        motions.append(_join_at_jumps(table, jumps, False) if jumps else close_rows(table.t, table.x))
    failure = None
    for motion in motions:
        try:
            return find_segment_ends(EventSearch(numeric, p, motion), segments), motion
        except SignatureError as exc:
            failure = exc
    assert failure is not None, "a gap is one of the two"
    raise failure


def _join_at_jumps(table: MotionTable, jumps: list[int], at_end: bool) -> SampledMotion:
    """Return the motion that jumps before some rows, and ``at_end`` from the last row to the first."""
    t, x = table.t, table.x
    parts = [(t[a:b], x[a:b]) for a, b in pairwise([0, *jumps, len(t)])]
    edges = np.array([t[0], *t[jumps], t[-1]])
    if not at_end:
        parts, edges = _join_around(parts, t[-1] - t[0]), edges[1:-1]
        edges = np.append(edges, edges[0] + t[-1] - t[0])
    return join_rows([part[0] for part in parts], [part[1] for part in parts], edges)


def _join_around(parts: list[tuple[Array, Array]], period: float) -> list[tuple[Array, Array]]:
    """Return the parts of a period, the last and the first, a period later, as one."""
    (t, x), (later, ends) = parts[-1], parts[0]
    return [*parts[1:-1], (np.concatenate([t, later + period]), np.concatenate([x, ends]))]


def _split_blocks(table: MotionTable) -> list[tuple[int, int]]:
    """Return the rows, first and beyond the last, between which the segment is one."""
    if table.segment is None:
        return [(0, len(table.t))]
    jumps = set(_find_jumps(table))
    cuts = [i for i in range(1, len(table.t)) if i in jumps or table.segment[i] != table.segment[i - 1]]
    return list(pairwise([0, *cuts, len(table.t)]))


def _find_signature(
    model: Model, table: MotionTable, blocks: list[tuple[int, int]], given: tuple[str, ...], mode: str | None
) -> tuple[str, ...]:
    """Return the segments that a table runs through; none for a motion without events."""
    labels = () if table.segment is None else tuple(table.segment[a] for a, _ in blocks)
    if given or mode is not None or model.smooth:
        return given
    if labels and all(isinstance(label, str) for label in labels):
        for (row, _), label in zip(blocks, labels, strict=True):
            if label not in model.segments:
                raise SignatureError(
                    f"line {table.line[row]}: '{str(label)[:MAX_SHOWN]}' is not a segment of this model"
                    f"{model.hint('segments', str(label), model.segments)} (segments: {', '.join(model.segments)})"
                )
        joined = len(labels) > 1 and labels[0] == labels[-1] and _find_gap(table) <= CLOSED
        return tuple(map(str, labels[1:] if joined else labels))
    what = "the segments are numbers" if labels else "nothing says which segments the rows run through"
    raise SignatureError(
        f"{what}: give 'signature', their names in order (segments: {', '.join(model.segments)}), or 'mode' for an "
        f"orbit that meets no event (modes: {', '.join(model.modes)})"
    )


def _cut_at_blocks(
    numeric: NumericModel, p: Array, table: MotionTable, blocks: list[tuple[int, int]], names: tuple[str, ...]
) -> tuple[Array, SampledMotion]:
    """Return where segments begin and end, by what the table says, and the motion.

    A segment ends in the gap between its last row and the next: where its event function, read on from its own rows,
    crosses zero or is nearest to it.
    """
    assert table.segment is not None, "blocks are those of a column"
    period, labels = float(table.t[-1] - table.t[0]), [table.segment[a] for a, _ in blocks]
    parts = [(table.t[a:b], table.x[a:b]) for a, b in blocks]
    if len(blocks) == len(names) + 1 and labels[0] == labels[-1]:
        # The rows begin inside of a segment.
        blocks, labels, parts = blocks[1:], labels[1:], _join_around(parts, period)
    first = _find_first(names, labels, [table.line[a] for a, _ in blocks])
    for (t, _), label in zip(parts, labels, strict=True):
        if not t[-1] > t[0]:
            raise SignatureError(
                f"the rows of segment '{label}' are all at t = {t[0]:.10g}; expected two times or more in a segment"
            )
    n, begins, ends = len(names), [t[0] for t, _ in parts], np.array([t[-1] for t, _ in parts])
    gaps = list(zip(ends, [*begins[1:], begins[0] + period], strict=True))
    motion = join_rows([t for t, _ in parts], [x for _, x in parts], np.append(ends[-1] - period, ends))
    search = EventSearch(numeric, p, motion)
    segments = [numeric.model.segments[names[(k - first) % n]] for k in range(n)]
    cuts = [search.find_end(segments[k], k, *gap) if gap[1] > gap[0] else gap[0] for k, gap in enumerate(gaps)]
    edges = [cuts[-1] - period, *cuts]
    motion = replace(motion, edges=np.array(edges))
    return np.array([*edges[first:], *(edge + period for edge in edges[1 : first + 1])]), motion


def _find_first(names: tuple[str, ...], labels: list[str | int], lines: list[int]) -> int:
    """Return which of the blocks with ``labels`` is the signature's first; raise SignatureError if none is."""
    n = len(names)
    known = [(k, names[k - 1]) for k in range(1, n + 1)]
    matches = []
    for first in range(n):
        fits = [label in known[(j - first) % n] for j, label in enumerate(labels)]
        if len(labels) == n and all(fits):
            return first
        matches.append(fits.index(False) if False in fits else n)
    at = max(matches)
    where = f"line {lines[at]} begins segment '{labels[at]}'" if at < len(labels) else f"there are {len(labels)}"
    raise SignatureError(
        f"the rows run through segments [{', '.join(map(str, labels[:MAX_TOLD]))}"
        f"{', ..' if len(labels) > MAX_TOLD else ''}], not through the signature [{', '.join(names)}] once: {where}"
    )
