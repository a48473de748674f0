"""What a run gives, or a results file holds: steps by name, pictures and the page of all of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from pddecont.api.step_results import StepResults
from pddecont.errors import ResultsError, printable
from pddecont.results import Results, read_results
from pddecont.tables import summarise

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class RunResults:
    """What a results file holds: a mapping from the names of steps to steps."""

    results: Results

    @property
    def path(self) -> Path:
        """The file that was read; one that ``run`` made for itself is there no more."""
        return self.results.path

    @property
    def model(self) -> str:
        """Name of the model."""
        return next((str(step.meta.get("model", "")) for step in self.results.steps.values()), "")

    def __iter__(self) -> Iterator[str]:
        return iter(self.results.names)

    def __len__(self) -> int:
        return len(self.results.names)

    def __contains__(self, name: object) -> bool:
        return name in self.results.steps

    def __getitem__(self, name: str) -> StepResults:
        """Return a step by name; raise ResultsError, with the steps there are, for any other."""
        return StepResults(self.results, self.results.step(name))

    def __repr__(self) -> str:
        return printable("\n".join([f"<{self._describe()}", *(f"  {self[name]!r}" for name in self)]) + ">")

    def _repr_html_(self) -> str:
        from pddecont.notebook import render_results

        return render_results(self.results, self._describe())

    def _describe(self) -> str:
        kept = f" in {self.path}" if self.path.exists() else ""
        return f"results of {self.model or 'a run'}{kept}"

    def branch(self, name: str) -> xarray.Dataset:
        """Return a step as a data set: :meth:`StepResults.dataset`."""
        return self[name].dataset()

    def summary(self) -> dict[str, Any]:
        """Return what ``pddecont info --json`` says."""
        return summarise(self.results)

    @overload
    def plot(
        self,
        path: None = None,
        *,
        view: str | None = None,
        steps: Sequence[str] = (),
        x: str | None = None,
        y: str | None = None,
        z: str | None = None,
        labels: Sequence[str] = (),
        indices: Sequence[int] = (),
        size: str | None = None,
        style: str | None = None,
        beside: Sequence[RunResults] = (),
    ) -> Figure: ...

    @overload
    def plot(
        self,
        path: str | Path,
        *,
        view: str | None = None,
        steps: Sequence[str] = (),
        x: str | None = None,
        y: str | None = None,
        z: str | None = None,
        labels: Sequence[str] = (),
        indices: Sequence[int] = (),
        size: str | None = None,
        style: str | None = None,
        beside: Sequence[RunResults] = (),
    ) -> None: ...

    def plot(
        self,
        path: str | Path | None = None,
        *,
        view: str | None = None,
        steps: Sequence[str] = (),
        x: str | None = None,
        y: str | None = None,
        z: str | None = None,
        labels: Sequence[str] = (),
        indices: Sequence[int] = (),
        size: str | None = None,
        style: str | None = None,
        beside: Sequence[RunResults] = (),
    ) -> Figure | None:
        """Return a picture as a matplotlib figure or, with ``path``, write it there as ``pddecont plot`` does.

        Parameters
        ----------
        path
            Where the picture goes; its suffix says in which format.
        view, steps, x, y, z, labels, indices, size, style
            As the options of ``pddecont plot``.
        beside
            Other results in the same picture.

        Raises
        ------
        ResultsError
            If there is no such view, step, column, label or index, or the file's name ends like no picture's.
        """
        from pddecont.plot import ViewRequest, apply_style, draw_picture, read_size, save_picture

        if any(i < 0 for i in indices):
            raise ResultsError(f"there is no index {min(indices)}; indices of points begin with 0")
        files = [self.results, *(other.results for other in beside)]
        request = ViewRequest(view, tuple(steps), x, y, z, tuple(labels), tuple(indices))
        asked = read_size(size) if size else None
        if path is not None:
            save_picture(files, request, Path(path), style, asked)
            return None
        with apply_style(style, asked):
            return draw_picture(files, request)

    def report(self, path: str | Path, *, beside: Sequence[RunResults] = ()) -> None:
        """Write the page that ``pddecont report`` writes, of these results and of others ``beside``.

        Raises
        ------
        ResultsError
            If the file's name does not end like a page's, or what is there is no such page.
        """
        from pddecont.api.pages import write_report

        write_report([self.results, *(other.results for other in beside)], Path(path))


def load(path: str | Path) -> RunResults:
    """Return what the results file at ``path`` holds, finished or not.

    Raises
    ------
    ResultsError
        If it is no results file that this version can read.
    """
    return RunResults(read_results(path))
