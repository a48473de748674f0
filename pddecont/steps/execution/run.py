"""A whole run: its steps one after another, into one results file."""

from __future__ import annotations

import contextlib
import gc
import importlib.metadata
import json
import platform
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pddecont.errors import PddecontError, ResultsError, RunError, suggest
from pddecont.model import parse_document
from pddecont.output import refuse_link
from pddecont.results import Results, create_results, hold_lock, read_results, upgrade_results
from pddecont.runfile import Plan, PlannedStep
from pddecont.simulate import Workers, lend_one_thread
from pddecont.steps.budget import Budget
from pddecont.steps.context import Context
from pddecont.steps.execution.all_steps import do_steps
from pddecont.steps.execution.sources import check_sources
from pddecont.steps.reporter import Reporter, Silent
from pddecont.version import __version__

PACKAGES = ("numpy", "scipy", "sympy", "h5py", "llvmlite")
# Bytes of a block larger than nearly all arrays of a run; pages of it that nobody writes to take no memory.
LARGE_BLOCK = 1 << 24


def execute(
    plan: Plan,
    path: Path,
    reporter: Reporter | None = None,
    *,
    resume: bool = False,
    overwrite: bool = False,
    only: str | None = None,
    until: str | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    budget: Budget | None = None,
) -> None:
    """Do the steps of ``plan`` and keep their results in the file at ``path``.

    Raises
    ------
    RunError, ResultsError
        If the file exists and neither ``resume`` nor ``overwrite`` is given, or it belongs to another run, or a step
        has nothing to start from; nothing is written then.
    ConvergenceError
        If a step fails; what was computed before it stays in the file.
    """
    steps = select_steps(plan, only, until)
    check_output(plan, path)
    with hold_lock(path):
        kept = read_results(path) if resume and path.exists() else None
        if kept is not None:
            check_same_run(plan, kept)
        check_sources(plan, steps, path, kept)
        if kept is not None:
            upgrade_results(kept)
        else:
            source = plan.source.encode(errors="backslashreplace").decode()
            versions = json.dumps(find_versions())
            create_results(path, plan.model_text, plan.run_text, source, versions, overwrite=overwrite)
        file = kept or read_results(path)
        context = Context(plan, path, reporter or Silent(), Workers(workers, scheduler), file=file)
        context.budget = budget or Budget()
        with lend_one_thread(), _sparing_collections():
            _keep_freed_memory()
            do_steps(context, steps)


@contextlib.contextmanager
def _sparing_collections() -> Iterator[None]:
    """Keep the garbage collector from looking through all that is there already, again and again: it stays.

    That is a hundred thousand objects of libraries and of the model, a tenth of the time of a branch.
    """
    if gc.get_freeze_count():
        yield
        return
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def _keep_freed_memory() -> None:
    """Let the process keep the memory of arrays that are gone for those to come, and not hand it back between them.

    The C library of Linux does so for all that is no larger than the largest block that was ever freed (mallopt(3), on
    M_MMAP_THRESHOLD); every page that it asks for again costs 2 us, at some 60 pages a point of a branch.
    """
    np.empty(LARGE_BLOCK, dtype=np.uint8)


def check_output(plan: Plan, path: Path) -> None:
    """Raise ResultsError if ``path`` is a link, or a file that the run was read from."""
    refuse_link(path)
    for what, source in plan.inputs.items():
        if path.is_file() and Path(source).is_file() and path.samefile(source):
            raise ResultsError(f"{path} is the {what} of this run and is left as it is; give another -o")


def select_steps(plan: Plan, only: str | None, until: str | None) -> Sequence[PlannedStep[Any]]:
    """Return the steps to do; raise RunError for a name that is not a step's."""
    names = [step.name for step in plan.steps]
    for option, name in (("--only", only), ("--until", until)):
        if name is not None and name not in names:
            raise RunError.at(
                f"{option} {name}", 0, 0, f"is not a step of this run{suggest(name, names)} (steps: {', '.join(names)})"
            )
    if only is not None:
        return [plan.find_step(only)]
    return plan.steps if until is None else plan.steps[: names.index(until) + 1]


def check_same_run(plan: Plan, recorded: Results) -> None:
    """Raise ResultsError unless the file that ``recorded`` was read from was made from the same model and run."""
    path = recorded.path
    for what, here, there in (
        ("model", plan.model_text, recorded.model_text),
        ("run file", plan.run_text, recorded.run_text),
    ):
        if here != there:
            if what == "model" and _apart_from_run(here) == _apart_from_run(there):
                raise ResultsError(
                    f"{path} was made by another run of this model: what has changed is the model file's 'run' block, "
                    "or how the file is written. The results are left as they are. Give --overwrite to replace them, "
                    "or another -o; to continue them, put the file back as it was"
                )
            raise ResultsError(
                f"{path} was made from another {what} than the one given now; it is left as it is. Give --overwrite to "
                "replace it, or another -o"
            )


def _apart_from_run(model_text: str) -> dict[str, Any]:
    """Return what a model file says, its 'run' block left out."""
    try:
        data = parse_document(model_text, "the model").data
    except PddecontError:
        return {"text": model_text}
    return {key: value for key, value in data.items() if key != "run"}


def find_versions() -> dict[str, str]:
    """Return the versions of this program and of what its numbers depend on."""
    return {
        "pddecont": __version__,
        "python": platform.python_version(),
        **{name: importlib.metadata.version(name) for name in PACKAGES},
    }
