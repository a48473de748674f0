"""Whether what a run's steps start from is there, before anything is written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pddecont.errors import RunError
from pddecont.results import Results, read_results
from pddecont.runfile import Holding, Plan, PlannedStep, Source
from pddecont.steps.registry import list_step_kinds


def check_sources(plan: Plan, steps: Sequence[PlannedStep[Any]], path: Path, kept: Results | None) -> None:
    """Check that each step starts from one that is done before it, from a simulation, or from one in a file that stays.

    Raises
    ------
    RunError
        If a step has nothing to start from.
    ResultsError
        If the file that a step starts from, or the step or the point in it, is not there.
    """
    kinds = list_step_kinds()
    coming: set[str] = set()
    for step in steps:
        source = step.source
        if source is None or (kept is not None and step.name in kept.steps and kept.steps[step.name].done):
            pass
        elif source.file is not None:
            file = plan.base / source.file
            if kept is None and file.resolve() == path.resolve():
                raise RunError.at(
                    plan.source,
                    0,
                    0,
                    f"step '{step.name}' starts from {path}, which this run would replace; give another -o",
                )
            _check_point(read_results(file, source.step), source)
        elif source.step in coming or kinds[plan.find_step(source.step).kind].holds == Holding.TRAJECTORY:
            pass
        elif kept is None:
            raise RunError.at(
                plan.source,
                0,
                0,
                f"step '{step.name}' starts from step '{source.step}', which is not done in this run; "
                "give --resume with a results file that holds it, or do the steps above too",
            )
        else:
            _check_point(kept, source)
        coming.add(step.name)


def _check_point(results: Results, source: Source) -> None:
    """Raise ResultsError if a results file does not hold the point that ``source`` names."""
    found = results.step(source.step)
    if source.point is not None:
        found.row(source.point)
