"""Tables as data frames of pandas, where that is installed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.results import Step
from pddecont.tables.column_texts import describe_column, find_unit
from pddecont.tables.endings import describe_endings

if TYPE_CHECKING:
    import pandas


def make_frame(step: Step, table: str, rows: Sequence[Mapping[str, Any]]) -> pandas.DataFrame:
    """Return the rows of a table of ``step`` as a data frame: unknown truths and counts are NA, unknown numbers NaN.

    ``attrs`` holds ``units`` and ``doc`` of the columns that have them, and ``step``, ``kind``, ``table``, ``model``
    and ``termination``.

    Raises
    ------
    ResultsError
        If pandas is not installed.
    """
    try:
        import pandas
    except ImportError as exc:
        raise ResultsError(
            "data frames need pandas, which is not installed; install 'pddecont[pandas]', or use 'arrays'"
        ) from exc
    names = list(rows[0]) if rows else []
    texts = {name: describe_column(step, table, name) for name in names}
    frame = pandas.DataFrame(
        {name: _make_column([row[name] for row in rows], texts[name].type) for name in names}, columns=names
    )
    units = {name: find_unit(step, table, name) for name in names}
    frame.attrs = {
        "step": step.name,
        "kind": step.kind,
        "table": table,
        "model": str(step.meta.get("model", "")),
        "termination": "\n".join(describe_endings(step)),
        "units": {name: unit for name, unit in units.items() if unit},
        "doc": {name: text.text for name, text in texts.items() if text.text},
    }
    return frame


def _make_column(values: list[Any], kind: str | None) -> Any:
    import pandas

    if kind is not None:
        return pandas.array(values, dtype=kind)
    if any(value is None for value in values):
        return np.array([np.nan if value is None else float(value) for value in values])
    return values
