"""The Python interface, which the command line is built on: a run as a function, its results as arrays and data sets.

>>> import pddecont
>>> results = pddecont.run("wright", mesh={"degree": 4, "tol": 1e-4}, only="transient")
>>> list(results)
['transient']
>>> results["transient"].arrays()["x"].ndim
1
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.results import Results, Step, read_results
from pddecont.runfile import Overrides, Plan, write_run
from pddecont.steps import Budget, Reporter, load_run_plan
from pddecont.steps.execution import execute
from pddecont.tables import make_arrays, make_dataset, make_orbit_arrays, make_table, summarise

if TYPE_CHECKING:
    import xarray

# The name of the step that explores.
EXPLORATION = "explore"


@dataclass(frozen=True, eq=False)
class StepResults:
    """One step of a run."""

    step: Step

    @property
    def name(self) -> str:
        """Name of the step."""
        return self.step.name

    @property
    def kind(self) -> str:
        """Kind of the step: ``simulate``, ``orbit``, ``continue``, ``sweep``, ``basin`` or ``precision``."""
        return self.step.kind

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of special points in order along the branch."""
        return tuple(self.step.labels[i] for i in self.step.order if self.step.labels[i])

    def __len__(self) -> int:
        return len(self.step)

    def __repr__(self) -> str:
        special = f", {', '.join(self.labels)}" if self.labels and self.kind == "continue" else ""
        return f"<{self.kind} step '{self.name}', {len(self)} point{'s'[: len(self) - 1]}{special}>"

    def table(self, name: str = "points", label: str | None = None) -> list[dict[str, Any]]:
        """Return a table as ``pddecont export`` writes it, one mapping a row.

        Raises
        ------
        ResultsError
            If this kind of step has no such table, or the step no point ``label``.
        """
        return make_table(self.step, name, None if label is None else self.step.row(label))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the step's main table as arrays by column.

        Its rows are points in order along a branch, or times of a trajectory.
        """
        return make_arrays(self.step)

    def orbit(self, label: str | int = 0) -> dict[str, NDArray[Any]]:
        """Return an orbit, of a label or an index, as arrays at its base points: ``t``, ``segment`` and each state.

        Raises
        ------
        ResultsError
            If the step holds no orbits, or none of this label or index.
        """
        return make_orbit_arrays(self.step, self.step.row(label) if isinstance(label, str) else label)

    def dataset(self) -> xarray.Dataset:
        """Return :meth:`arrays` as a data set with units; the free parameters and labels are coordinates. Needs xarray.

        Raises
        ------
        ResultsError
            If xarray is not installed.
        """
        return make_dataset(self.step)


@dataclass(frozen=True, eq=False)
class RunResults:
    """What a results file holds: a mapping from the names of steps to steps."""

    results: Results

    @property
    def path(self) -> Path:
        """The file that was read; one that ``run`` made for itself is there no more."""
        return self.results.path

    def __iter__(self) -> Iterator[str]:
        return iter(self.results.names)

    def __len__(self) -> int:
        return len(self.results.names)

    def __contains__(self, name: object) -> bool:
        return name in self.results.steps

    def __getitem__(self, name: str) -> StepResults:
        """Return a step by name; raise ResultsError, with the steps there are, for any other."""
        return StepResults(self.results.step(name))

    def __repr__(self) -> str:
        return "\n".join([f"<results of {self.path}", *(f"  {self[name]!r}" for name in self)]) + ">"

    def branch(self, name: str) -> xarray.Dataset:
        """Return a step as a data set: :meth:`StepResults.dataset`."""
        return self[name].dataset()

    def summary(self) -> dict[str, Any]:
        """Return what ``pddecont info --json`` says."""
        return summarise(self.results)

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
        style: str | None = None,
    ) -> Any:
        """Return a picture as a matplotlib figure or, with ``path``, write it there as ``pddecont plot`` does.

        Raises
        ------
        ResultsError
            If there is no such view, step, column, label or index, or the file's name ends like no picture's.
        """
        from pddecont.plot import ViewRequest, apply_style, draw_picture, save_picture

        if any(i < 0 for i in indices):
            raise ResultsError(f"there is no index {min(indices)}; indices of points begin with 0")
        request = ViewRequest(view, tuple(steps), x, y, z, tuple(labels), tuple(indices))
        if path is not None:
            save_picture(self.results, request, Path(path), style)
            return None
        with apply_style(style):
            return draw_picture(self.results, request)


def load(path: str | Path) -> RunResults:
    """Return what the results file at ``path`` holds, finished or not.

    Raises
    ------
    ResultsError
        If it is no results file that this version can read.
    """
    return RunResults(read_results(path))


def plan(
    model: str | Path | Mapping[str, Any],
    *,
    steps: Sequence[Mapping[str, Any]] | None = None,
    overrides: Overrides | None = None,
    **run_keys: Any,
) -> Plan:
    """Return the checked run that :func:`run` does; raise ModelError or RunError with all that is wrong."""
    return load_run_plan(write_run(model, steps, run_keys), overrides)


def run(
    model: str | Path | Mapping[str, Any],
    *,
    steps: Sequence[Mapping[str, Any]] | None = None,
    output: str | Path | None = None,
    set: Mapping[str, str | float] | None = None,
    without: Sequence[str] = (),
    only: str | None = None,
    until: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    workers: int = 1,
    scheduler: str | None = None,
    reporter: Reporter | None = None,
    **run_keys: Any,
) -> RunResults:
    """Do a run and return its results.

    Parameters
    ----------
    model
        A model or run file: its path, the name of a shipped one, YAML text, or a mapping with its keys.
    steps
        The steps, as in a run file, in place of those that ``model`` describes itself.
    output
        Results file; without one nothing is kept but what is returned.
    set, without
        Values of parameters, and effects left out.
    only, until, resume, overwrite, workers, scheduler
        As the options of ``pddecont run``.
    reporter
        Hears how the run goes.
    **run_keys
        Other keys of a run file in place of the run's own: ``delay``, ``mesh``, ``monitors``, ``effects``,
        ``accuracy``.

    Raises
    ------
    ModelError, RunError
        With all that is wrong in the model or the run, each at its place.
    ResultsError
        If ``output`` exists and neither ``resume`` nor ``overwrite`` is given, or belongs to another run.
    ConvergenceError, SignatureError
        If a step fails; what was computed before it is in ``output``.

    Warns
    -----
    UserWarning
        For each thing in the files that is suspicious but not wrong.
    """
    values = tuple((name, str(value)) for name, value in (set or {}).items())
    checked = plan(model, steps=steps, overrides=Overrides(values, tuple(without)), **run_keys)
    return _compute_warning(
        checked,
        output,
        reporter,
        resume=resume,
        overwrite=overwrite,
        only=only,
        until=until,
        workers=workers,
        scheduler=scheduler,
    )


def plan_exploration(
    model: str | Path | Mapping[str, Any],
    over: Mapping[str, Sequence[str | float]],
    overrides: Overrides | None = None,
    **settings: Any,
) -> Plan:
    """Return the checked run that :func:`explore` does; raise ModelError or RunError with all that is wrong."""
    fields = {"over": {name: list(limits) for name, limits in over.items()}, **settings}
    return plan(model, steps=[{"name": EXPLORATION, "explore": fields}], overrides=overrides)


def explore(
    model: str | Path | Mapping[str, Any],
    over: Mapping[str, Sequence[str | float]],
    *,
    output: str | Path | None = None,
    set: Mapping[str, str | float] | None = None,
    without: Sequence[str] = (),
    time: float | None = None,
    max_branches: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    workers: int = 1,
    scheduler: str | None = None,
    reporter: Reporter | None = None,
    **settings: Any,
) -> RunResults:
    """Compute a whole diagram as ``pddecont explore`` does; return its results, step ``explore`` with all the others.

    Parameters
    ----------
    model
        As for :func:`run`; the run's own steps are not done.
    over
        One or two parameters with their lowest and highest value.
    time, max_branches
        Seconds after which no step is begun, and most branches; what was left goes on with ``resume``.
    **settings
        Other keys of an ``explore`` step: ``box``, ``transient``, ``starts``, ``check``, ``depth`` and so on.

    The other parameters, errors and warnings are those of :func:`run`.
    """
    values = tuple((name, str(value)) for name, value in (set or {}).items())
    checked = plan_exploration(model, over, Overrides(values, tuple(without)), **settings)
    return _compute_warning(
        checked,
        output,
        reporter,
        resume=resume,
        overwrite=overwrite,
        workers=workers,
        scheduler=scheduler,
        budget=Budget(time, max_branches),
    )


def _compute_warning(checked: Plan, output: str | Path | None, reporter: Reporter | None, **options: Any) -> RunResults:
    """Warn of what is suspicious in a plan, do it, and return its results; without an output no file is left."""
    for warning in checked.warnings:
        warnings.warn(str(warning), stacklevel=3)
    if output is not None:
        return compute(checked, Path(output), reporter, **options)
    with tempfile.TemporaryDirectory(prefix="pddecont-") as folder:
        return compute(checked, Path(folder) / "results.h5", reporter, **options)


def compute(checked: Plan, path: Path, reporter: Reporter | None = None, **options: Any) -> RunResults:
    """Do a checked run into the file at ``path`` and return its results.

    The options are those of :func:`pddecont.steps.execution.execute`.
    """
    execute(checked, path, reporter, **options)
    return load(path)
