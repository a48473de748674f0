"""Runs and explorations as functions."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

from pddecont.api.run_keys import ExploreKeys, RunKeys
from pddecont.api.run_results import RunResults, load
from pddecont.notebook import choose_reporter
from pddecont.runfile import Overrides, Plan, write_run
from pddecont.steps import Budget, Reporter, load_run_plan
from pddecont.steps.execution import execute

# The name of the step that explores.
EXPLORATION = "explore"


def plan(
    model: str | Path | Mapping[str, Any],
    *,
    steps: Sequence[Mapping[str, Any]] | None = None,
    overrides: Overrides | None = None,
    **run_keys: Unpack[RunKeys],
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
    **run_keys: Unpack[RunKeys],
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
        Hears how the run goes; without one a notebook shows a bar (``pddecont.steps.Silent()`` shows none).
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
    **settings: Unpack[ExploreKeys],
) -> Plan:
    """Return the checked run that :func:`explore` does; raise ModelError or RunError with all that is wrong."""
    fields: dict[str, Any] = {"over": {name: list(limits) for name, limits in over.items()}, **settings}
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
    **settings: Unpack[ExploreKeys],
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
    with choose_reporter(reporter) as heard:
        if output is not None:
            return compute(checked, Path(output), heard, **options)
        with tempfile.TemporaryDirectory(prefix="pddecont-") as folder:
            return compute(checked, Path(folder) / "results.h5", heard, **options)


def compute(checked: Plan, path: Path, reporter: Reporter | None = None, **options: Any) -> RunResults:
    """Do a checked run into the file at ``path`` and return its results.

    The options are those of :func:`pddecont.steps.execution.execute`.
    """
    execute(checked, path, reporter, **options)
    return load(path)
