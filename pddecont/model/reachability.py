"""Segments and modes that no motion can come to."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from pddecont.model.parts import Segment
from pddecont.model.transitions import WAYS


def find_shadowed(segments: Collection[Segment]) -> Iterator[tuple[str, str]]:
    """Yield each segment that can never happen, as others above it end at all that it ends at, with what is wrong.

    Where several segments of one mode end at one event, the first whose direction fits is taken.
    """
    above: dict[tuple[str, str], list[Segment]] = {}
    for segment in segments:
        others = above.setdefault((segment.mode, segment.event), [])
        taken = [other for other in others if WAYS[other.direction] & WAYS[segment.direction]]
        if WAYS[segment.direction] <= set().union(*(WAYS[other.direction] for other in others)):
            names = " and ".join(f"'{other.name}'" for other in taken)
            way = "" if segment.direction == "any" else f" {segment.direction}"
            yield (
                segment.name,
                f"segment '{segment.name}' can never happen: {names} above ends mode '{segment.mode}' at event "
                f"'{segment.event}'{way} already; give it another event or direction, or remove it",
            )
        others.append(segment)


def find_unreached(first: str, modes: Collection[str], segments: Collection[Segment]) -> Iterator[tuple[str, str]]:
    """Yield each mode that motions from mode ``first`` do not come to, with a word on it.

    A run may put motions into such a mode itself.
    """
    led_to = {segment.to for segment in segments}
    reached, waiting = {first}, [first]
    while waiting:
        mode = waiting.pop()
        following = {segment.to for segment in segments if segment.mode == mode} - reached
        reached |= following
        waiting += following
    for mode in modes:
        if mode in reached:
            continue
        if mode not in led_to:
            yield mode, f"no segment leads to mode '{mode}'"
        else:
            yield mode, f"mode '{mode}' is not reached from the initial mode '{first}'; only others like it lead to it"
