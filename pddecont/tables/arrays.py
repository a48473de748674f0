"""A step's main table as arrays, and as a data set of xarray where that is installed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.results import Step
from pddecont.tables.column_texts import describe_column, find_unit
from pddecont.tables.endings import describe_endings
from pddecont.tables.equilibria import holds_equilibria, read_roots
from pddecont.tables.orbits import list_orbit, read_multipliers
from pddecont.tables.registry import find_main_table, make_table

if TYPE_CHECKING:
    import xarray


def make_arrays(step: Step) -> dict[str, NDArray[Any]]:
    """Return the main table of a step by column, shape (n_rows,) each: a trajectory's times, else points in order.

    What was not computed is NaN; a column of truths of which some are not known holds 1.0, 0.0 and NaN.
    """
    return _to_columns(make_table(step, find_main_table(step.kind), 0 if step.kind == "simulate" else None))


def make_orbit_arrays(step: Step, i: int) -> dict[str, NDArray[Any]]:
    """Return the orbit of point ``i`` at its base points.

    It holds ``t``, ``segment`` (from 1) and the states, shape (n_base,) each.
    """
    if "segment" not in step.orbits:
        raise ResultsError(f"step '{step.name}' is a {step.kind} step and holds no orbits")
    return _to_columns(list_orbit(step, i))


def _to_columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    names = list(rows[0]) if rows else []
    return {name: _to_array([row[name] for row in rows]) for name in names}


def _to_array(values: list[Any]) -> NDArray[Any]:
    if any(v is None for v in values):
        return np.array([np.nan if v is None else float(v) for v in values])
    return np.array(values)


def make_dataset(step: Step) -> xarray.Dataset:
    """Return :func:`make_arrays` as a data set over ``point`` (or ``t``); ``units`` and ``long_name`` are attributes.

    Free parameters and labels are coordinates. Where Floquet multipliers were computed they are there too, complex over
    (point, number), NaN beyond the last; so are the characteristic roots of equilibria.
    """
    try:
        import xarray
    except ImportError as exc:
        raise ResultsError(
            "data sets need xarray, which is not installed; install 'pddecont[xarray]', or use 'arrays'"
        ) from exc
    columns, table = make_arrays(step), find_main_table(step.kind)
    dim = "t" if step.kind == "simulate" else "point"
    held = [name for name in ("t", "label", *(step.meta.get("free") or [])) if name in columns]
    variables = {name: (dim, values, _describe(step, table, name)) for name, values in columns.items()}
    attributes = {
        "step": step.name,
        "kind": step.kind,
        "model": step.meta.get("model", ""),
        "termination": "\n".join(describe_endings(step)),
    }
    result = xarray.Dataset(variables, attrs=attributes).set_coords([name for name in held if name != dim])
    spectra = {"multiplier": read_multipliers, **({"root": read_roots} if holds_equilibria(step) else {})}
    for name, read in spectra.items():
        found = [read(step, int(i)) for i in step.order]
        if any(len(z) for z in found):
            values = np.full((len(found), max(map(len, found))), np.nan + 0j)
            for row, z in zip(values, found, strict=True):
                row[: len(z)] = z
            result[name] = (("point", "number"), values)
    return result


def _describe(step: Step, table: str, name: str) -> dict[str, str]:
    """Return the attributes of a variable, as the conventions for climate and forecasts name them."""
    found = {"units": find_unit(step, table, name), "long_name": describe_column(step, table, name).text}
    return {key: text for key, text in found.items() if text}
