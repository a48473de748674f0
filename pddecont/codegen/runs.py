"""Rows of outputs that are one number, or numbers that lie in a row, as loops.

A reset of a large system leaves most states as they are, and its derivatives hold as many ones: as loops they take
neither source nor machine code that grows with the states.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TypeAlias

# Shorter rows are written out: a loop of few turns is no faster.
SHORTEST = 16
# A place and what is written there.
Entry: TypeAlias = tuple[int, str]

# What is worked out already: a number, a common part, a place in an array, or one of these with its sign changed.
_KNOWN = re.compile(r"-?[\w.]+(\[\d+\])?\Z")
_ELEMENT = re.compile(r"(\w+)\[(\d+)\]\Z")


def write_outputs(entries: Iterable[Entry]) -> list[str]:
    """Return the lines that write ``out``, from places in order and what is written there: loops, then single lines."""
    left, lines = list(entries), []
    for find in (_find_copies, _find_fills):
        if len(left) >= SHORTEST:
            loops, left = find(left)
            lines += loops
    return lines + [f"out[{place}] = {text}" for place, text in left]


def _find_copies(entries: Sequence[Entry]) -> tuple[list[str], list[Entry]]:
    """Return loops that copy parts of arrays, and the other entries."""
    lines: list[str] = []
    left: list[Entry] = []
    run: list[Entry] = []
    last: tuple[str, int] | None = None

    def close() -> None:
        if last is None or len(run) < SHORTEST:
            left.extend(run)
            return
        array, shift = last
        moved = f" {'+' if shift > 0 else '-'} {abs(shift)}" if shift else ""
        lines.extend(_write_loop(run[0][0], run[-1][0] + 1, 1, f"{array}[k{moved}]"))

    for place, text in entries:
        element = _ELEMENT.match(text)
        source = None if element is None else (element[1], int(element[2]) - place)
        if source is None or source != last or place != run[-1][0] + 1:
            close()
            run = []
        run.append((place, text))
        last = source
    close()
    return lines, left


def _find_fills(entries: Sequence[Entry]) -> tuple[list[str], list[Entry]]:
    """Return loops that write one number to places equally far apart, and the other entries."""
    places: dict[str, list[int]] = {}
    for place, text in entries:
        if _KNOWN.match(text):
            places.setdefault(text, []).append(place)
    lines: list[str] = []
    written: set[int] = set()
    for text, found in places.items():
        for run in _split_evenly(found):
            if len(run) >= SHORTEST:
                lines += _write_loop(run[0], run[-1] + 1, run[1] - run[0], text)
                written.update(run)
    return lines, [entry for entry in entries if entry[0] not in written]


def _split_evenly(places: Sequence[int]) -> list[list[int]]:
    """Return places in order as rows, in each of which they are equally far apart."""
    rows: list[list[int]] = [[]]
    for place in places:
        row = rows[-1]
        if len(row) > 1 and place - row[-1] != row[1] - row[0]:
            # A row of two that happens to be followed by another one gives its last place to it.
            rows.append([row.pop()] if len(row) == 2 else [])
            row = rows[-1]
        row.append(place)
    return rows


def _write_loop(first: int, end: int, step: int, text: str) -> list[str]:
    return [f"for k in range({first}, {end}, {step}):", f"    out[k] = {text}"]
