"""A whole run: its steps one after another, into one results file."""

from __future__ import annotations

import importlib.metadata
import json
import platform
from pathlib import Path
from typing import Any

from pddecont.errors import PddecontError, ResultsError, RunError, suggest
from pddecont.model.document import parse_document
from pddecont.results.lock import writing
from pddecont.results.reader import Step as RecordedStep
from pddecont.results.reader import read_results
from pddecont.results.writer import create, drop_steps, seal
from pddecont.simulate.workers import Workers
from pddecont.steps.accuracy import resolved
from pddecont.steps.context import Context, Reporter, Silent, settings_text
from pddecont.steps.continuation import run_continue
from pddecont.steps.orbit import run_orbit
from pddecont.steps.plan import Plan
from pddecont.steps.precision import run_precision
from pddecont.steps.schema import Step
from pddecont.steps.sources import check_sources
from pddecont.version import __version__

PACKAGES = ("numpy", "scipy", "sympy", "h5py", "numba")


def execute(plan: Plan, path: Path, reporter: Reporter | None = None, *, resume: bool = False, overwrite: bool = False,
            only: str | None = None, until: str | None = None, workers: int = 1,
            scheduler: str | None = None) -> None:  # fmt: skip
    """Do the steps of ``plan`` and keep their results in the file at ``path``.

    Raises
    ------
    RunError, ResultsError
        If the file exists and neither ``resume`` nor ``overwrite`` is given, or it belongs to another run, or a step has nothing to
        start from; nothing is written then.
    ConvergenceError
        If a step fails; what was computed before it stays in the file.
    """
    steps = chosen_steps(plan, only, until)
    if path.is_symlink():
        path = path.resolve()
    with writing(path):
        _execute(plan, path, steps, reporter or Silent(), Workers(workers, scheduler), resume=resume, overwrite=overwrite)


def _execute(plan: Plan, path: Path, steps: list[Step], reporter: Reporter, workers: Workers, *, resume: bool, overwrite: bool) -> None:
    going_on = path.exists() and resume
    if going_on:
        check_same(plan, path)
    check_sources(plan, steps, path, resume=resume)
    if not going_on:
        source = plan.source.encode(errors="backslashreplace").decode()
        create(path, plan.model_text, plan.run_text, source, json.dumps(versions()), overwrite=overwrite)
    context = Context(plan, path, reporter, workers)
    for step in steps:
        context.reporter.step(step.name, step.kind)
        recorded = read_results(path, step.name).steps.get(step.name)
        step = resolved(context, step, None if recorded is None else recorded.meta.get("choice"))
        if recorded is not None and recorded.meta.get("settings") != settings_text(plan, step):
            raise ResultsError(f"step '{step.name}' of {path} was computed with other settings; give --overwrite or another -o")
        if recorded is not None and recorded.done:
            seal(path, step.name)
            context.reporter.done("done already")
        elif step.continue_:
            run_continue(context, step, recorded)
        elif step.precision:
            run_precision(context, step, recorded)
        elif step.orbit:
            _anew(path, recorded)
            run_orbit(context, step)
        else:
            _simulate(context, step, recorded)


def _anew(path: Path, recorded: RecordedStep | None) -> None:
    """Drop what an unfinished step left, where it cannot be gone on with."""
    if recorded is not None:
        drop_steps(path, [recorded.name])


def _simulate(context: Context, step: Step, recorded: RecordedStep | None) -> None:
    """Do a step that simulates; the integrator is imported by runs that have one, and by no others."""
    from pddecont.simulate.kernel import cache_folder

    if not cache_folder().exists():
        context.reporter.note("the integrator is compiled, once an installation; this takes about a minute")
    from pddecont.steps.basin import run_basin
    from pddecont.steps.simulate import run_simulate
    from pddecont.steps.sweep import run_sweep

    if step.sweep:
        run_sweep(context, step, recorded)
    elif step.basin:
        run_basin(context, step, recorded)
    else:
        _anew(context.path, recorded)
        run_simulate(context, step)


def chosen_steps(plan: Plan, only: str | None, until: str | None) -> list[Step]:
    """Return the steps to do; raise RunError for a name that is not a step's."""
    steps = list(plan.run.steps)
    names = [s.name for s in steps]
    for option, name in (("--only", only), ("--until", until)):
        if name is not None and name not in names:
            raise RunError.at(f"{option} {name}", 0, 0, f"is not a step of this run{suggest(name, names)} (steps: {', '.join(names)})")
    if only is not None:
        return [steps[names.index(only)]]
    return steps if until is None else steps[: names.index(until) + 1]


def check_same(plan: Plan, path: Path) -> None:
    """Raise ResultsError unless the file at ``path`` was made from the same model and run."""
    recorded = read_results(path)
    for what, here, there in (("model", plan.model_text, recorded.model_text), ("run file", plan.run_text, recorded.run_text)):
        if here != there:
            if what == "model" and _apart_from_run(here) == _apart_from_run(there):
                raise ResultsError(f"{path} was made by another run of this model: what has changed is the model file's 'run' block, or "
                                   "how the file is written. The results are left as they are. Give --overwrite to replace them, or "
                                   "another -o; to go on with them, put the file back as it was")  # fmt: skip
            raise ResultsError(f"{path} was made from another {what} than the one given now; it is left as it is. Give --overwrite to "
                               "replace it, or another -o")  # fmt: skip


def _apart_from_run(model_text: str) -> dict[str, Any]:
    """Return what a model file says, its 'run' block left out."""
    try:
        data = parse_document(model_text, "the model").data
    except PddecontError:
        return {"text": model_text}
    return {key: value for key, value in data.items() if key != "run"}


def versions() -> dict[str, str]:
    """Return the versions of this program and of what its numbers depend on."""
    return {"pddecont": __version__, "python": platform.python_version(),
            **{name: importlib.metadata.version(name) for name in PACKAGES}}  # fmt: skip
