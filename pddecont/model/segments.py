"""A model file's segments: each once for every mode that it may lead to, and whether all that they name is there."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.errors import suggest
from pddecont.model.expression import Scope
from pddecont.model.findings import Findings
from pddecont.model.parts import IDENTITY, Segment
from pddecont.model.reachability import find_shadowed, find_unreached
from pddecont.model.rest import make_resting
from pddecont.model.schema import DelayedEvent, ModelFile
from pddecont.model.schema import Segment as SegmentBody
from pddecont.model.transitions import list_leaders
from pddecont.model.validation import ALTERNATIVE


def make_segments(file: ModelFile, scope: Scope, findings: Findings) -> dict[str, Segment]:
    """Return the segments of a file by name; ``findings`` takes what is wrong with their conditions."""
    made = (segment for name, body in file.segments.items() for segment in _list_ways(name, body, scope, findings))
    return {segment.name: segment for segment in made}


def _list_ways(name: str, body: SegmentBody, scope: Scope, findings: Findings) -> Iterator[Segment]:
    """Yield a segment of the file, once for each mode that it may lead to, with what has to hold then."""
    ways = list(_list_guarded(name, body, scope, findings))
    yield from ways
    if body.rest is None or not ways:
        return
    yield (resting := make_resting(ways[0], name, body.rest))
    if resting.name in {way.name for way in ways}:
        findings.add_error(
            ("segments", name, "rest"),
            f"segment '{name}' leads to mode '{body.rest}' by a condition too; give the rest a mode of its own",
        )


def _list_guarded(name: str, body: SegmentBody, scope: Scope, findings: Findings) -> Iterator[Segment]:
    """Yield a segment of the file, once for each mode that conditions let it lead to."""
    parts = body.mode, body.event, body.direction, body.reset
    if isinstance(body.to, str):
        yield Segment(name, *parts, body.to)
        return
    guards: dict[str, Boolean] = {}
    left, known = sympy.true, len(findings.problems)
    for i, way in enumerate(body.to):
        path = ("segments", name, "to", i)
        when = sympy.true if way.when is None else findings.condition((*path, "when"), way.when, scope)
        own, left = sympy.And(left, when), sympy.And(left, sympy.Not(when))
        if own == sympy.false and len(findings.problems) == known:
            findings.add_error(
                path,
                f"segment '{name}' never leads to mode '{way.mode}' here: one of the conditions above holds wherever "
                "this one does, or it contradicts itself; remove it or change their order",
            )
        guards[way.mode] = sympy.Or(guards.get(way.mode, sympy.false), own)
    if left != sympy.false and len(findings.problems) == known:
        findings.add_error(
            ("segments", name, "to"),
            f"segment '{name}' leads nowhere where none of its conditions holds; end the list with a mode without "
            "'when'",
        )
    for mode, guard in guards.items():
        yield Segment(f"{name}{ALTERNATIVE}{mode}", *parts, mode, name, guard)


def check_segments(
    file: ModelFile, segments: Mapping[str, Segment], resets: Collection[str], findings: Findings
) -> None:
    """Check that segments name what there is, that all there is is named, and that motions come to all of it."""
    _check_names(file, segments.values(), resets, findings)
    used = {s.event for s in segments.values()} | {e.after for e in file.events.values() if isinstance(e, DelayedEvent)}
    for name in file.events:
        if name not in used:
            findings.add_error(
                ("events", name),
                f"event '{name}' ends no segment; add a segment with 'event: {name}' or remove it",
                key=True,
            )
    if not segments and len(file.modes) > 1:
        findings.add_error(
            ("modes",), f"{len(file.modes)} modes but no segments lead from one to another; add segments", key=True
        )
    for name in file.resets:
        if name != IDENTITY and name not in {s.reset for s in segments.values()}:
            findings.add_warning(("resets", name), f"reset '{name}' is not used by any segment")
    for name, message in find_shadowed(list_leaders(segments.values())):
        findings.add_error(("segments", name), message, key=True)
    first = str(file.initial.get("mode", next(iter(file.modes))))
    for name, message in find_unreached(first, file.modes, segments.values()):
        findings.add_warning(("modes", name), message)


def _check_names(file: ModelFile, segments: Collection[Segment], resets: Collection[str], findings: Findings) -> None:
    """Check that what segments name is defined."""

    def check(segment: Segment, key: str, given: str, known: Collection[str], what: str) -> None:
        if given in known:
            return
        name, kind = segment.written or segment.name, what.split()[-1]
        findings.add_error(
            ("segments", name, key),
            f"segment '{name}' {what} '{given}', which is not defined "
            f"({kind}s: {', '.join(known) or 'none'}){suggest(given, known)}",
        )

    for segment in list_leaders(segments):
        check(segment, "mode", segment.mode, file.modes, "runs in mode")
        check(segment, "event", segment.event, file.events, "ends at event")
        check(segment, "reset", segment.reset, resets, "applies reset")
    for segment in segments:
        check(segment, "rest" if segment.rests else "to", segment.to, file.modes, "leads to mode")
        if segment.rests and isinstance(file.events.get(segment.event), DelayedEvent):
            findings.add_error(
                ("segments", segment.written, "rest"),
                f"segment '{segment.written}' ends at the delayed event '{segment.event}', where no impacts "
                "accumulate; remove 'rest', or end it at an event function",
            )
