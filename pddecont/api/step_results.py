"""One step of a run: its points, tables, orbits and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from pddecont.api.orbit import Orbit
from pddecont.api.point import Point
from pddecont.api.table import Table
from pddecont.errors import ResultsError, printable
from pddecont.results import Results, Step
from pddecont.tables import (
    describe_endings,
    find_main_table,
    list_tables,
    make_arrays,
    make_dataset,
    make_orbit_arrays,
    make_table,
)

if TYPE_CHECKING:
    import pandas
    import xarray

# Labels that are said in a line.
MAX_LABELS = 12


@dataclass(frozen=True, eq=False, repr=False)
class StepResults:
    """One step of a run."""

    results: Results
    step: Step

    @property
    def name(self) -> str:
        """Name of the step."""
        return self.step.name

    @property
    def kind(self) -> str:
        """Kind of the step, as in a run file; ``equilibria`` for a branch of equilibria."""
        return self.step.kind

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of special points in order along the branch."""
        return tuple(self.step.labels[i] for i in self.step.order if self.step.labels[i])

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables that :meth:`table` gives."""
        return tuple(list_tables(self.kind))

    @property
    def views(self) -> tuple[str, ...]:
        """Names of the views that the step gives by itself, its default first."""
        from pddecont.plot import list_views

        return tuple(view.name for view in list_views(self.step))

    @property
    def endings(self) -> tuple[str, ...]:
        """How the step ended, a branch in each direction, in sentences; none while it goes on."""
        return tuple(describe_endings(self.step))

    def __len__(self) -> int:
        return len(self.step)

    def point(self, label: str | int = 0) -> Point:
        """Return a point by label or index.

        Raises
        ------
        ResultsError
            If there is none, or the step has no table of points.
        """
        index = self.step.row(label) if isinstance(label, str) else label
        for row in make_table(self.step, "points"):
            if row["index"] == index:
                return Point(self.results, self.step, index, row)
        raise ResultsError(f"step '{self.name}' has {len(self)} points, no index {index}")

    def special_points(self) -> tuple[Point, ...]:
        """Return the points with labels, in order along the branch.

        Raises
        ------
        ResultsError
            If the step has no table of points.
        """
        rows = make_table(self.step, "points")
        return tuple(Point(self.results, self.step, row["index"], row) for row in rows if row["label"])

    def table(self, name: str | None = None, label: str | None = None) -> Table:
        """Return a table as ``pddecont export`` writes it, a sequence of mappings; without a name the main one.

        Raises
        ------
        ResultsError
            If this kind of step has no such table, or the step no point ``label``.
        """
        name = name or find_main_table(self.kind)
        row = None if label is None else self.step.row(label)
        return Table(self.step, name, tuple(make_table(self.step, name, row)))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the step's main table as arrays by column.

        Its rows are points in order along a branch, or times of a trajectory.
        """
        return make_arrays(self.step)

    def orbit(self, label: str | int = 0) -> Orbit:
        """Return an orbit, of a label or an index, as arrays at its base points: ``t``, ``segment`` and each state.

        Raises
        ------
        ResultsError
            If the step holds no orbits, or none of this label or index.
        """
        index = self.step.row(label) if isinstance(label, str) else label
        return Orbit(self.results, self.step, index, make_orbit_arrays(self.step, index))

    def dataset(self) -> xarray.Dataset:
        """Return :meth:`arrays` as a data set with units; the free parameters and labels are coordinates. Needs xarray.

        Raises
        ------
        ResultsError
            If xarray is not installed.
        """
        return make_dataset(self.step)

    def to_pandas(self, name: str | None = None, label: str | None = None) -> pandas.DataFrame:
        """Return a table as a data frame: ``table(name, label).to_pandas()``. Needs pandas.

        Raises
        ------
        ResultsError
            If pandas is not installed, or there is no such table.
        """
        return self.table(name, label).to_pandas()

    def __repr__(self) -> str:
        labels = self.labels if self.kind in ("continue", "equilibria") else ()
        shown = ", ".join(labels[:MAX_LABELS]) + (", ..." if len(labels) > MAX_LABELS else "")
        count = f"{len(self)} point{'s'[: len(self) != 1]}"
        return printable(f"<{self.kind} step '{self.name}', {count}{', ' if shown else ''}{shown}>")

    def _repr_html_(self) -> str:
        from pddecont.notebook import render_step

        return render_step(self.results, self.step, f"{self.name}: {self.kind}")
