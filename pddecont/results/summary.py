"""What a results file holds, in a few words for each step."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from pddecont.results.attractors import class_of
from pddecont.results.precision import cheapest_lines
from pddecont.results.reader import Results, Step

WORDS = {
    "GR": "grazing", "LP": "fold", "PD": "period doubling", "TR": "torus", "BP": "branch point", "VS": "vanishing segment",
    "EP": "end point", "UF": "user function", "CP": "cusp", "R1": "resonance 1:1", "R2": "resonance 1:2", "R3": "resonance 1:3",
    "R4": "resonance 1:4", "FF": "fold-flip", "FT": "fold-torus", "PT": "flip-torus", "TT": "double torus", "GG": "double grazing",
    "GL": "grazing with multiplier 1", "GP": "grazing with multiplier -1", "GT": "grazing with multipliers on the unit circle",
}  # fmt: skip
TRIVIAL_TOL = 1e-4


def summary(results: Results) -> dict[str, Any]:
    """Return the contents of a results file as plain data (``info --json``)."""
    left_out = [left_out_of(step) for step in results.steps.values()]
    # A file may be gone on with, step by step, without other effects.
    same = all(data == left_out[0] for data in left_out)
    steps = [step_summary(step) | ({} if same else {"left out": data}) for step, data in zip(results.steps.values(), left_out, strict=True)]
    return {"model": next((s.meta.get("model") for s in results.steps.values()), None), "versions": dict(results.versions),
            "left out": left_out[0] if left_out and same else {}, "steps": steps}  # fmt: skip


def left_out_of(step: Step) -> dict[str, Any]:
    """Return the effects that a step was computed without, and what went with them and why; empty if all were in."""
    data = json.loads(step.meta.get("settings") or "{}").get("left_out", {})
    return {"effects": data["effects"], **data} if data else {}


def effects_off(step: Step) -> list[str]:
    """Return the effects that a step was computed without."""
    return list(left_out_of(step).get("effects", []))


def step_summary(step: Step) -> dict[str, Any]:
    """Return a step's name, kind, number of points, special labels and how it ended; then what is known of its orbits."""
    result: dict[str, Any] = {
        "name": step.name, "kind": step.kind, "n_points": len(step), "done": step.done,
        "special": [step.labels[i] for i in step.order if step.labels[i]], "termination": list(step.termination),
    }  # fmt: skip
    if step.kind in ("sweep", "basin"):
        found = [class_of(step, i) for i in range(len(step)) if step.labels[i]]
        return result | {"special": [], "attractors": {name: found.count(name) for name in dict.fromkeys(found)}}
    if step.kind == "precision":
        return result | {"special": [], "cheapest": cheapest_lines(step) if len(step) else []}
    free = step.meta.get("free") or []
    if len(free) == 2:
        result |= {"free": list(free), "curve": step.meta.get("curve") or None}
    if "error_estimate" in step.points and len(step):
        result["error_estimate"] = float(step.points["error_estimate"].max())
        result["n_unknowns"] = int(step.points["n_unknowns"].max())
    met = list(dict.fromkeys(s for s in (signature(step, int(i)) for i in step.order) if s))
    return result | ({"signatures": met} if met else {}) | stability_summary(step)


def stability_summary(step: Step) -> dict[str, Any]:
    """Return how many points are stable and unstable, and the largest error of a trivial multiplier; empty if not computed."""
    stable = step.points.get("stable", np.empty(0))
    if not np.any(stable >= 0):
        return {}
    counts = {"stable": int(np.sum(stable == 1)), "unstable": int(np.sum(stable == 0)), "unknown": int(np.sum(stable < 0))}
    result: dict[str, Any] = {"stability": counts}
    errors = step.points.get("trivial_error", np.empty(0))
    if np.any(np.isfinite(errors)):
        worst = int(np.nanargmax(errors))
        result["trivial_error"] = float(errors[worst])
        if errors[worst] > TRIVIAL_TOL:
            result["warning"] = (f"the trivial multiplier is off by {errors[worst]:.2g} at index {worst} (more than {TRIVIAL_TOL:g}): "
                                 "its stability may be wrong; use a finer mesh (smaller tol, or more intervals)")  # fmt: skip
    return result


def signature(step: Step, row: int) -> str:
    """Return the names of the segments of a recorded orbit, separated by spaces; empty where none is recorded."""
    if "signature" not in step.orbits:
        return ""
    end = step.orbits["signature_end"]
    return step.orbits["signature"][end[row - 1] if row else 0 : end[row]].tobytes().decode()


def short_signature(text: str, longest: int = 44) -> str:
    """Return a signature with repeated groups counted, ``(NC C)×3 NC``, and cut in the middle where it is still long."""
    names = text.split()
    pieces, i = [], 0
    while i < len(names):
        size, times = _repeat(names[i:])
        group = " ".join(names[i : i + size])
        pieces.append(group if times == 1 else f"{group}×{times}" if size == 1 else f"({group})×{times}")
        i += size * times
    short = " ".join(pieces)
    if len(short) <= longest:
        return short
    half = longest // 2 - 1
    return f"{short[:half].rstrip()} … {short[-half:].lstrip()} ({len(names)} segments)"


def _repeat(names: list[str]) -> tuple[int, int]:
    """Return the length of the group that ``names`` begins with, and how often it stands there: what covers most."""
    best = (1, 1)
    for size in range(1, len(names) // 2 + 1):
        times = 1
        while names[:size] == names[times * size : (times + 1) * size]:
            times += 1
        if times > 1 and size * times > best[0] * best[1]:
            best = (size, times)
    return best
