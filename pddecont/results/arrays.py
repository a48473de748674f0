"""A step's main table as arrays, and as a data set of xarray where that is installed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.results.reader import Step
from pddecont.results.tables import multipliers, orbit_rows, table

if TYPE_CHECKING:
    import xarray

MAIN = {"simulate": "trajectory", "precision": "precision"}


def arrays(step: Step) -> dict[str, NDArray[Any]]:
    """Return the main table of a step by column, shape (n_rows,) each: a trajectory's times, else points in order.

    What was not computed is NaN; a column of truths of which some are not known holds 1.0, 0.0 and NaN.
    """
    return _columns(table(step, MAIN.get(step.kind, "points"), 0 if step.kind == "simulate" else None))


def orbit_arrays(step: Step, i: int) -> dict[str, NDArray[Any]]:
    """Return the orbit of point ``i`` at its base points: ``t``, ``segment`` (from 1) and the states, shape (n_base,) each."""
    if "segment" not in step.orbits:
        raise ResultsError(f"step '{step.name}' is a {step.kind} step and holds no orbits")
    return _columns(orbit_rows(step, i))


def _columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    names = list(rows[0]) if rows else []
    return {name: _array([row[name] for row in rows]) for name in names}


def _array(values: list[Any]) -> NDArray[Any]:
    if any(v is None for v in values):
        return np.array([np.nan if v is None else float(v) for v in values])
    return np.array(values)


def dataset(step: Step) -> xarray.Dataset:
    """Return :func:`arrays` as a data set over ``point`` (or ``t``), with free parameters and labels as coordinates, and units.

    Where Floquet multipliers were computed they are there too, complex over (point, number), NaN beyond the last.
    """
    try:
        import xarray
    except ImportError as exc:
        raise ResultsError("data sets need xarray, which is not installed; install 'pddecont[xarray]', or use 'arrays'") from exc
    columns, units = arrays(step), step.meta.get("units", {})
    dim = "t" if step.kind == "simulate" else "point"
    held = [name for name in ("t", "label", *(step.meta.get("free") or [])) if name in columns]
    variables = {name: (dim, values, {"units": units[name]} if name in units else {}) for name, values in columns.items()}
    if "period" in variables and "t" in units and step.kind in ("orbit", "continue"):
        variables["period"][2]["units"] = units["t"]
    attributes = {"step": step.name, "kind": step.kind, "model": step.meta.get("model", ""), "termination": "\n".join(step.termination)}
    result = xarray.Dataset(variables, attrs=attributes).set_coords([name for name in held if name != dim])
    found = [multipliers(step, int(i)) for i in step.order]
    if any(len(z) for z in found):
        table_of = np.full((len(found), max(map(len, found))), np.nan + 0j)
        for row, z in zip(table_of, found, strict=True):
            row[: len(z)] = z
        result["multiplier"] = (("point", "number"), table_of)
    return result
