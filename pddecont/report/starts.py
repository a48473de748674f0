"""Run files that start from a point of a results file, for somebody to copy."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from pddecont.results import Results, Step
from pddecont.tables import list_effects_off

# By what share of its value a parameter varies where the file does not say in which range.
SHARE = 0.1
_MODEL_LINE = re.compile(r"^model:[ \t]+\S.*$", re.MULTILINE)


def write_start(results: Results, step: Step) -> tuple[str, str] | None:
    """Return a run file that goes on from a point of a step, as what stands before and after the point's place.

    Between them belongs ``point: LABEL`` or ``index: ROW``. Attractors are solved as orbits, orbits and equilibria are
    followed: along the parameter and range of their own step, else the first parameter around its value.
    """
    if not len(step) or not ("free" in step.meta or step.kind in ("orbit", "equilibrium", "basin")):
        return None
    settings = json.loads(step.meta.get("settings") or "{}")
    lines = [_name_model(results), *_list_settings(step, settings), "steps:"]
    before = (
        f"  - {{name: from_here, {{KIND}}: {{from: {{file: {_write(results.path.name)}, step: {_write(step.name)}, "
    )
    if step.kind in ("sweep", "basin"):
        return "\n".join([*lines, before.replace("{KIND}", "orbit")]), "}, stability: true}}\n"
    own = settings.get("step", {}).get("continue") or {}
    free = list(own.get("free") or step.meta.get("free") or step.meta["parameters"])[:1]
    if not free:
        return None
    limits = own.get("range", {}).get(free[0]) or _choose_range(step, free[0])
    after = f"}}, free: {_write(free)}, range: {_write({free[0]: limits})}, stability: true}}}}\n"
    return "\n".join([*lines, before.replace("{KIND}", "continue")]), after


def _name_model(results: Results) -> str:
    """Return the line that names the model, as the run file had it; a model with its own run is that file."""
    found = _MODEL_LINE.search(results.run_text) if results.run_text != results.model_text else None
    return found[0].rstrip() if found else f"model: {_write(Path(results.source).name)}"


def _list_settings(step: Step, settings: Mapping[str, Any]) -> list[str]:
    """Return the lines of a run file that say how the step was computed."""
    own = settings.get("step", {})
    lines = []
    for name in ("delay", "mesh"):
        values = (settings.get(name) or {}) | {k: v for k, v in (own.get(name) or {}).items() if v is not None}
        known = {key: value for key, value in values.items() if value is not None}
        if known:
            lines.append(f"{name}: {_write(known)}")
    if off := list_effects_off(step):
        lines.append(f"effects: {_write({'off': off})}")
    if monitors := settings.get("monitors"):
        lines.append(f"monitors: {_write(monitors)}")
    return lines


def _choose_range(step: Step, name: str) -> list[float]:
    value = float(step.points["parameters"][0, list(step.meta["parameters"]).index(name)])
    width = SHARE * abs(value) or SHARE
    return [value - width, value + width]


def _write(value: Any) -> str:
    """Return a value as YAML that may stand within a line."""
    text = yaml.safe_dump([value], default_flow_style=True, allow_unicode=True, sort_keys=False, width=math.inf)
    return text.strip()[1:-1]
