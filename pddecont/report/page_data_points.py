"""Every number of each point, for axes and rows of the explorer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pddecont.plot import list_columns, read_column
from pddecont.report.packed_arrays import ArrayPacker
from pddecont.results import Step
from pddecont.tables import find_main_table, make_table

# Whole numbers beyond the table's that axes may show too.
WHOLE = ("n_periods",)


def describe_points(packer: ArrayPacker, step: Step) -> dict[str, Any]:
    """Return the columns of a step's main table, and other numbers of its points, in the table's order.

    ``columns`` lists name, kind (``number``, ``whole``, ``truth``, ``text``) and values: texts as they are, else where
    the array lies; what was not computed is NaN.
    """
    rows = make_table(step, find_main_table(step.kind))
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    order = columns["index"]
    for name in [*list_columns(step), *(n for n in WHOLE if n in step.points)] if "arclength" in step.points else ():
        if name not in columns:
            columns[name] = read_column(step, name)[order].tolist()
    return {"n": len(rows), "columns": [_describe(packer, name, values) for name, values in columns.items()]}


def _describe(packer: ArrayPacker, name: str, values: Sequence[Any]) -> list[Any]:
    known = [value for value in values if value is not None]
    if any(isinstance(value, str) for value in known):
        return [name, "text", ["" if value is None else str(value) for value in values]]
    kind = "truth" if known and all(isinstance(value, bool) for value in known) else "number"
    if kind == "number" and all(isinstance(value, int) for value in known):
        kind = "whole"
    return [name, kind, packer.add([np.nan if value is None else float(value) for value in values], "<f8")]
