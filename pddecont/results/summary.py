"""What a results file holds, in a few words for each step."""

from __future__ import annotations

from typing import Any

from pddecont.results.reader import Results, Step


def summary(results: Results) -> dict[str, Any]:
    """Return the contents of a results file as plain data (``info --json``)."""
    return {"model": next((s.meta.get("model") for s in results.steps.values()), None), "versions": dict(results.versions),
            "steps": [step_summary(step) for step in results.steps.values()]}  # fmt: skip


def step_summary(step: Step) -> dict[str, Any]:
    """Return a step's name, kind, number of points, special labels and how it ended."""
    result: dict[str, Any] = {
        "name": step.name, "kind": step.kind, "n_points": len(step), "done": step.done,
        "special": [step.labels[i] for i in step.order if step.labels[i]], "termination": list(step.termination),
    }  # fmt: skip
    if "error_estimate" in step.points and len(step):
        result["error_estimate"] = float(step.points["error_estimate"].max())
        result["n_unknowns"] = int(step.points["n_unknowns"].max())
    return result
