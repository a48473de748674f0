"""Steps of results files of earlier formats as this one holds them.

Format 2 held sentences, and this is the only place that reads them; both it and format 3 lack columns.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.reasons import NO_REASON, Reason, make_reason

Arrays = dict[str, NDArray[Any]]
# How sentences on motions that lead to no attractor begin, by the code of what they say.
_FAILURES = {
    "accumulation": re.compile(r"events of '(?P<event>.*?)' accumulate at"),
    "sliding": re.compile(r"event '(?P<event>.*?)' leads, at"),
    "undefined": re.compile(r"the simulation ends at"),
    "not finite": re.compile(r"the solution is no longer finite near"),
    "step too small": re.compile(r"no step is small enough near"),
    "section left": re.compile(r"the motion no longer returns to the section after"),
    "no return": re.compile(r"the motion does not come back to the section"),
    "not settled": re.compile(r"the motion has not settled"),
    "equilibrium": re.compile(r"the motion stays at an equilibrium"),
}
_CHAIN = re.compile(r"chain of order (\d+)(, explicit states)?")


def add_columns(kind: str, points: Arrays, orbits: Arrays) -> tuple[Arrays, Arrays]:
    """Return the arrays of a step of format 2 or 3 with the columns that they lack: nothing is known of what they say.

    No orbit was simulated from its own past, and what was not located was counted only where the branch ended.
    """
    if "multipliers" in orbits and "residual" not in orbits:
        residuals = np.full(len(orbits["multipliers"]), np.nan)
        orbits = {**orbits, "residual": residuals, "residual_end": orbits["multipliers_end"]}
    if kind in ("orbit", "continue") and "arclength" in points:
        n = len(points["arclength"])
        unknown: Arrays = {"verified": np.full(n, -1, dtype="i1"), "deviation": np.full(n, np.nan)}
        points = {**unknown, **({"unexplained": np.zeros(n, dtype="i4")} if kind == "continue" else {}), **points}
    return points, orbits


def upgrade_step(
    kind: str, meta: Mapping[str, Any], points: Arrays, orbits: Arrays, lines: Sequence[bytes]
) -> tuple[Arrays, Arrays, tuple[Reason, ...]]:
    """Return the arrays of a step of format 2, and how its directions ended, as this format holds them."""
    endings = tuple(_upgrade_ending(line.decode(errors="replace")) for line in lines)
    if "note" in points:
        labels = points.get("kind", np.zeros(len(points["note"]), dtype="S1"))
        users = _user_functions(meta)
        notes = zip(labels.tolist(), points["note"].tolist(), strict=True)
        reasons = [
            _upgrade_failure(note.decode(errors="replace"))
            if not label and kind in ("sweep", "basin")
            else _upgrade_note(label, note.decode(errors="replace"), users)
            for label, note in notes
        ]
        points = {name: values for name, values in points.items() if name != "note"}
        orbits = {**orbits, **_pack([reason.to_json().encode() for reason in reasons])}
    if kind == "precision" and "family" in points:
        points = _upgrade_settings(points)
    return *add_columns(kind, points, orbits), endings


def _upgrade_ending(text: str) -> Reason:
    direction = -1 if text.startswith("down:") else 1 if text.startswith("up:") else 0
    return make_reason("text", text=text, direction=direction)


def _user_functions(meta: Mapping[str, Any]) -> list[str]:
    """Return the names of a step's user functions."""
    step = json.loads(meta.get("settings") or "{}").get("step", {})
    body = step.get("continue") if isinstance(step, dict) else None
    functions = body.get("events_along") if isinstance(body, dict) else None
    return list(functions) if isinstance(functions, dict) else []


def _upgrade_note(label: bytes, note: str, users: Sequence[str]) -> Reason:
    if not note:
        return NO_REASON
    if label == b"UF":
        # The format cut names to 32 bytes.
        return make_reason("user_function", name=next((name for name in users if name.startswith(note)), note))
    if label == b"PD" and note == "halves become equal":
        return make_reason("halves_equal")
    if label == b"GG":
        return make_reason("grazing")
    if label == b"VS":
        event, meets, other = note.partition(" meets ")
        if meets:
            return make_reason("meeting", event=event, other=other)
        if note.endswith(" vanishes"):
            return make_reason("vanishing", segment=note.removesuffix(" vanishes"))
        return make_reason("tangential")
    return make_reason("text", text=note)


def _upgrade_failure(note: str) -> Reason:
    """Return why a motion leads to no attractor, with the sentence, which was cut to its column's length."""
    for code, beginning in _FAILURES.items():
        match = beginning.match(note)
        if match:
            return make_reason(code, **match.groupdict(), text=note)
    return make_reason("not settled", text=note) if note else NO_REASON


def _pack(texts: Sequence[bytes]) -> Arrays:
    """Return texts as one array of bytes and where each ends."""
    ends = np.cumsum([len(text) for text in texts], dtype=np.int64)
    return {"reason": np.frombuffer(b"".join(texts), dtype=np.uint8), "reason_end": ends}


def _upgrade_settings(points: Arrays) -> Arrays:
    """Return the columns of a comparison with methods in fields instead of words."""
    families = [family.decode(errors="replace") for family in points["family"].tolist()]
    chains = [_CHAIN.fullmatch(family) for family in families]
    methods = ["chain" if chain else family.partition(",")[0] for family, chain in zip(families, chains, strict=True)]
    kept = {name: values for name, values in points.items() if name not in ("family", "setting")}
    return {
        **kept,
        "method": np.array([method.encode() for method in methods], dtype="S16"),
        "tracked": np.array([family != "direct, not tracked" for family in families], dtype=np.int8),
        "order": np.array([int(chain[1]) if chain else 0 for chain in chains], dtype=np.int32),
        "explicit": np.array([bool(chain and chain[2]) for chain in chains], dtype=np.int8),
    }
