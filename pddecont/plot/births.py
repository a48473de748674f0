"""Where branches of orbits are born: the Hopf points that they start from."""

from __future__ import annotations

import json
from collections.abc import Sequence

from pddecont.plot.several_files import split_name
from pddecont.results import Step
from pddecont.tables import holds_equilibria


def find_birth(step: Step, steps: Sequence[Step]) -> tuple[Step, int] | None:
    """Return the step and the row of the Hopf point at which a branch's orbits are born, if it is one of ``steps``."""
    settings = json.loads(step.meta.get("settings") or "{}").get("step", {})
    asked = settings.get("continue") if isinstance(settings, dict) else None
    start = asked.get("from") if isinstance(asked, dict) and asked.get("branch") == "switch" else None
    if holds_equilibria(step) or not isinstance(start, dict) or start.get("file"):
        return None
    place = (split_name(step)[0], start.get("step"))
    source = next((s for s in steps if split_name(s) == place and holds_equilibria(s)), None)
    if source is None or start.get("point") not in source.labels:
        return None
    row = source.labels.index(start["point"])
    return (source, row) if source.kind_of(row) == "HB" else None
