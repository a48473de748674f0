"""Tables of simulations: states over time, events."""

from __future__ import annotations

from typing import Any

import numpy as np

from pddecont.results import Step

Row = dict[str, Any]


def list_trajectory(step: Step, i: int) -> list[Row]:
    """Return one row a time of a trajectory."""
    rows = step.orbit(i)
    names, modes = [*step.meta["states"], *step.meta.get("signals", [])], step.meta["modes"]
    values = np.hstack([rows["states"], rows["signals"]]) if "signals" in rows else rows["states"]
    return [
        {"t": float(t), "mode": modes[m], **dict(zip(names, map(float, z), strict=True))}
        for t, m, z in zip(rows["time"], rows["mode"], values, strict=True)
    ]


def list_events(step: Step, i: int) -> list[Row]:
    """Return one row an event of a trajectory: states before the reset, and after it as ``NAME_after``."""
    rows = step.orbit(i)
    names, segments = step.meta["states"], step.meta["segments"]
    columns = (rows["event_time"], rows["event_segment"], rows["before"], rows["after"])
    return [
        {
            "t": float(t),
            "segment": segments[s],
            **dict(zip(names, map(float, a), strict=True)),
            **{f"{name}_after": float(v) for name, v in zip(names, b, strict=True)},
        }
        for t, s, a, b in zip(*columns, strict=True)
    ]
