"""What a results file holds, in a few words for each step."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from pddecont.results import Results, Step
from pddecont.tables.attractors import name_motion
from pddecont.tables.endings import TRIVIAL_ERROR, count_unknown, describe_endings, describe_unstated
from pddecont.tables.equilibria import holds_equilibria
from pddecont.tables.orbits import find_signature
from pddecont.tables.precision import describe_cheapest
from pddecont.tables.words import name_kind


def summarise(results: Results) -> dict[str, Any]:
    """Return the contents of a results file as plain data (``info --json``)."""
    left_out = [find_left_out(step) for step in results.steps.values()]
    # A file may be continued, step by step, without other effects.
    same = all(data == left_out[0] for data in left_out)
    steps = [
        summarise_step(step) | ({} if same else {"left out": data})
        for step, data in zip(results.steps.values(), left_out, strict=True)
    ]
    return {
        "model": next((s.meta.get("model") for s in results.steps.values()), None),
        "versions": dict(results.versions),
        "left out": left_out[0] if left_out and same else {},
        "steps": steps,
    }


def find_left_out(step: Step) -> dict[str, Any]:
    """Return the effects that a step was computed without, and what went with them and why; empty if all were in."""
    data = json.loads(step.meta.get("settings") or "{}").get("left_out", {})
    return {"effects": data["effects"], **data} if data else {}


def list_effects_off(step: Step) -> list[str]:
    """Return the effects that a step was computed without."""
    return list(find_left_out(step).get("effects", []))


def summarise_step(step: Step) -> dict[str, Any]:
    """Return a step's name, kind, number of points, special labels, how it ended, and what is known of its points."""
    result: dict[str, Any] = {
        "name": step.name,
        "kind": step.kind,
        "n_points": len(step),
        "done": step.done,
        "special": [step.labels[i] for i in step.order if step.labels[i]],
        "termination": describe_endings(step),
    }
    if step.kind in ("sweep", "basin"):
        found = [name_motion(step, i) for i in range(len(step)) if step.labels[i]]
        return result | {"special": [], "attractors": {name: found.count(name) for name in dict.fromkeys(found)}}
    if step.kind == "precision":
        return result | {"special": [], "cheapest": describe_cheapest(step) if len(step) else []}
    free = step.meta.get("free") or []
    if len(free) == 2:
        curve = step.meta.get("curve") or None
        result |= {"free": list(free), "curve": curve, "curve name": name_kind(step, curve) if curve else None}
    if "error_estimate" in step.points and len(step):
        result["error_estimate"] = float(step.points["error_estimate"].max())
        result["n_unknowns"] = int(step.points["n_unknowns"].max())
    found = list(dict.fromkeys(s for s in (find_signature(step, int(i)) for i in step.order) if s))
    name = "modes" if holds_equilibria(step) else "signatures"
    return result | ({name: found} if found else {}) | count_verified(step) | count_stable(step)


def count_verified(step: Step) -> dict[str, Any]:
    """Return how many orbits their simulations confirmed, and how far these ended away; empty where none was asked."""
    verified = step.points.get("verified", np.empty(0))
    if not np.any(verified >= 0) and not count_unknown(step, "verified"):
        return {}
    counts = {name: int(np.sum(verified == value)) for name, value in (("yes", 1), ("no", 0), ("not done", -1))}
    deviation = step.points["deviation"]
    known = deviation[np.isfinite(deviation)]
    return {"verified": counts, **({"deviation": float(known.max())} if len(known) else {})}


def count_stable(step: Step) -> dict[str, Any]:
    """Return how many points are stable and unstable, and the largest error of a trivial multiplier.

    The mapping is empty if they were not computed.
    """
    stable = step.points.get("stable", np.empty(0))
    if not np.any(stable >= 0) and not count_unknown(step, "stable"):
        return {}
    counts = {
        "stable": int(np.sum(stable == 1)),
        "unstable": int(np.sum(stable == 0)),
        "unknown": int(np.sum(stable < 0)),
    }
    result: dict[str, Any] = {"stability": counts}
    warnings = []
    if count_unknown(step, "stable"):
        warnings.append(describe_unstated(step, count_unknown(step, "stable")))
    errors = step.points.get("trivial_error", np.empty(0))
    if np.any(np.isfinite(errors)):
        worst = int(np.nanargmax(errors))
        result["trivial_error"] = float(errors[worst])
        if errors[worst] > TRIVIAL_ERROR:
            warnings.append(
                f"the trivial multiplier is off by {errors[worst]:.2g} at index {worst} (more than {TRIVIAL_ERROR:g}): "
                "its stability may be wrong; use a finer mesh (smaller tol, or more intervals)"
            )
    return result | ({"warning": "; ".join(warnings)} if warnings else {})


def shorten_signature(text: str, longest: int = 44) -> str:
    """Return a signature with repeated groups counted, ``(NC C)×3 NC``.

    It is cut in the middle where it is still longer than ``longest`` characters.
    """
    names = text.split()
    pieces, i = [], 0
    while i < len(names):
        size, times = _find_repetition(names[i:])
        group = " ".join(names[i : i + size])
        pieces.append(group if times == 1 else f"{group}×{times}" if size == 1 else f"({group})×{times}")
        i += size * times
    short = " ".join(pieces)
    if len(short) <= longest:
        return short
    half = longest // 2 - 1
    counted = f" ({len(names)} segments)" if len(names) > 1 else ""
    return f"{short[:half].rstrip()} … {short[-half:].lstrip()}{counted}"


def _find_repetition(names: list[str]) -> tuple[int, int]:
    """Return the length of the group that ``names`` begins with, and how often it is there: what covers most."""
    best = (1, 1)
    for size in range(1, len(names) // 2 + 1):
        times = 1
        while names[:size] == names[times * size : (times + 1) * size]:
            times += 1
        if times > 1 and size * times > best[0] * best[1]:
            best = (size, times)
    return best
