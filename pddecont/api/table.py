"""A table of a step: rows as mappings, which a notebook shows, and a way out to pandas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

from pddecont.errors import printable
from pddecont.results import Step
from pddecont.tables import describe_column, find_unit, make_frame

if TYPE_CHECKING:
    import pandas

Row = dict[str, Any]
# Names of columns that are said in a line.
MAX_NAMES = 8


@dataclass(frozen=True, eq=False, repr=False)
class Table(Sequence[Row]):
    """Rows of a table as ``pddecont export`` writes it, one mapping a row."""

    step: Step
    name: str
    rows: tuple[Row, ...]

    @overload
    def __getitem__(self, index: int) -> Row: ...

    @overload
    def __getitem__(self, index: slice) -> Table: ...

    def __getitem__(self, index: int | slice) -> Row | Table:
        """Return a row, or a table of some of the rows."""
        if isinstance(index, slice):
            return Table(self.step, self.name, self.rows[index])
        return self.rows[index]

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns; none where there are no rows."""
        return tuple(self.rows[0]) if self.rows else ()

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one."""
        found = {name: find_unit(self.step, self.name, name) for name in self.columns}
        return {name: unit for name, unit in found.items() if unit}

    @property
    def doc(self) -> dict[str, str]:
        """What each column holds, in words."""
        found = {name: describe_column(self.step, self.name, name).text for name in self.columns}
        return {name: text for name, text in found.items() if text}

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a data frame: unknown truths and counts are NA, unknown numbers NaN. Needs pandas.

        Its ``attrs`` hold ``units`` and ``doc`` of the columns, and which step it is of.

        Raises
        ------
        ResultsError
            If pandas is not installed.
        """
        return make_frame(self.step, self.name, self.rows)

    def __repr__(self) -> str:
        names = ", ".join(self.columns[:MAX_NAMES]) + (", ..." if len(self.columns) > MAX_NAMES else "")
        count = f"{len(self)} row{'s'[: len(self) != 1]}"
        return printable(f"<table '{self.name}' of step '{self.step.name}', {count}{': ' if names else ''}{names}>")

    def _repr_html_(self) -> str:
        from pddecont.notebook import render_rows

        return render_rows(self.step, self.name, self.rows, f"{self.step.name}: {self.name}")
