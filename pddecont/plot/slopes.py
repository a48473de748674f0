"""How fast what is drawn changes along a branch, from the tangents that are stored with its points.

A tangent holds the derivatives of a point's unknowns with respect to the length along the branch: of an orbit its base
values (n_base n_states), durations and others, last its free parameters; of an equilibrium its states, others, and the
free parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.columns import find_state, list_columns, list_free_parameters, read_column
from pddecont.plot.interpolated_orbits import interpolate_values
from pddecont.results import Step
from pddecont.tables import holds_equilibria

Array = NDArray[np.float64]


def read_slopes(step: Step, name: str) -> Array:
    """Return what :func:`read_heights` reads, differentiated by the arclength, shape (n_lines, n_points).

    They are known of parameters, the period, states of equilibria and the extremes of orbits, and NaN of all else. The
    sign is that of the stored tangent, which may point either way along the branch.
    """
    is_extent = name in step.meta["states"] and name not in list_columns(step)
    slopes = np.full((2 if is_extent else 1, len(step)), np.nan)
    if not step.format.has_branch:
        return slopes
    for row in range(len(step)):
        orbit = step.orbit(row)
        if len(orbit.get("tangent", ())):
            slopes[:, row] = _read_slope(step, orbit, name, is_extent)
    return slopes


def _read_slope(step: Step, orbit: Mapping[str, Any], name: str, is_extent: bool) -> Any:
    tangent, free = orbit["tangent"], list_free_parameters(step)
    if name in free:
        return tangent[len(tangent) - len(free) + free.index(name)]
    if name in step.meta["parameters"]:
        return 0.0
    if holds_equilibria(step):
        return tangent[find_state(step, name)] if name in step.meta["states"] else np.nan
    n_values, n_segments = orbit["states"].size, int(orbit["mesh"][1])
    if name == "period":
        return np.sum(tangent[n_values : n_values + n_segments])
    return _read_extent_slopes(step, orbit, name) if is_extent else np.nan


def _read_extent_slopes(step: Step, orbit: Mapping[str, Any], name: str) -> Array:
    """Return how fast the largest and the smallest value of a state change: as the orbit does where they are.

    Where these lie moves too, which changes nothing in them: inside the orbit is level there, and at the end of a
    segment it is a base point, whose own derivative is in the tangent.
    """
    j = find_state(step, name)
    values = interpolate_values(orbit, orbit["states"][:, j])
    changes = interpolate_values(orbit, orbit["tangent"][: orbit["states"].size].reshape(orbit["states"].shape)[:, j])
    return changes[[np.argmax(values), np.argmin(values)]]


def turn_slopes(slopes: Array, columns: Array, along: Array) -> Array:
    """Return slopes (n_columns, n) of points in order, with the signs that go with columns over ``along`` (n,).

    Those of a point all turn together: it is as its neighbours say, each column by its own size.
    """
    size = np.ptp(columns, axis=1)[:, None]
    scale = np.where(size > 0.0, size, 1.0)
    between = np.gradient(columns, along, axis=1)
    agreement = np.nansum(slopes * between / scale**2, axis=0)
    return np.where(agreement < 0.0, -slopes, slopes)


def read_columns_with_slopes(step: Step, *names: str) -> tuple[Array, Array]:
    """Return columns of points by name and their slopes, both of shape (n_names, n_points)."""
    columns = np.vstack([read_column(step, name) for name in names])
    return columns, np.vstack([read_slopes(step, name)[:1] for name in names])
