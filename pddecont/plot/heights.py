"""What diagrams show upwards: a number of each point or, of orbits and a state, its largest and its smallest value."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.columns import choose_monitor, find_state, list_columns, list_free_parameters, read_column
from pddecont.plot.interpolated_orbits import interpolate_segments
from pddecont.plot.limits import measure_size, varies
from pddecont.results import Step
from pddecont.tables import holds_equilibria

Array = NDArray[np.float64]


def read_heights(step: Step, name: str) -> Array:
    """Return what is drawn of each point by a name, shape (n_lines, n_points).

    Of orbits and the name of a state that are its largest and its smallest value along each orbit; else one column.
    """
    if name in step.meta["states"] and name not in list_columns(step):
        return np.transpose([_find_extent(step, row, name) for row in range(len(step))])
    return np.asarray(read_column(step, name), dtype=float)[None, :]


def choose_columns(steps: Sequence[Step]) -> tuple[str, str]:
    """Return what a diagram of steps shows when nobody says.

    Over the free parameter of the last one stands a monitor (:func:`choose_monitor`) or, where equilibria are among
    them, a state; equilibria that lie on no branch are shown in the plane of the first two states.
    """
    states = list(steps[-1].meta["states"])
    if not any(step.format.has_branch for step in steps) and holds_equilibria(steps[-1]) and len(states) > 1:
        return states[0], states[1]
    x = (list_free_parameters(steps[-1]) or steps[-1].meta["parameters"][:1] or ["period"])[0]
    return x, choose_height(steps)


def choose_height(steps: Sequence[Step]) -> str:
    """Return what stands over parameters: a monitor or, where equilibria are among ``steps``, a state that varies."""
    if not any(holds_equilibria(step) for step in steps):
        return choose_monitor(steps[-1])
    return choose_state(steps)


def choose_state(steps: Sequence[Step]) -> str:
    """Return the first state that varies."""
    states: list[str] = list(steps[-1].meta["states"])
    return next((name for name in states if _varies(steps, name)), states[0])


def _varies(steps: Sequence[Step], name: str) -> bool:
    """Return whether a state varies beyond rounding, along orbits or from point to point."""
    values = np.concatenate([read_heights(step, name).ravel() for step in steps if name in step.meta["states"]])
    return varies(values, measure_size(steps, values))


def _find_extent(step: Step, row: int, name: str) -> tuple[float, float]:
    """Return a state's largest and smallest value along an orbit."""
    j = find_state(step, name)
    values = np.concatenate([found[:, j] for _, found in interpolate_segments(step, row)])
    return float(np.max(values)), float(np.min(values))
