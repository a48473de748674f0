"""What the steps of one run share: the plan, the results file, trajectories in memory, who hears how it goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results import Results, RowWriter, Step, StepWriter, drop_steps, read_results
from pddecont.runfile import Plan, PlannedStep, Source
from pddecont.steps.budget import Budget
from pddecont.steps.reporter import Reporter

if TYPE_CHECKING:
    from pddecont.results import StepFormat
    from pddecont.simulate import Elsewhere, Trajectory, Workers

Array = NDArray[np.float64]


@dataclass(eq=False)
class Context:
    """State of a run in progress.

    ``file`` is what the results file holds, to which nobody else writes meanwhile (None: no file yet). ``make_writer``
    makes what takes a step's rows; ``elsewhere`` is where parts of a step are begun early (None: nowhere); ``budget``
    is what explorations may spend.
    """

    plan: Plan
    path: Path
    reporter: Reporter
    workers: Workers
    trajectories: dict[str, Trajectory] = field(default_factory=dict)
    file: Results | None = None
    make_writer: Callable[..., RowWriter] = StepWriter
    elsewhere: Elsewhere | None = None
    budget: Budget = field(default_factory=Budget)

    def read_source(self, source: Source) -> tuple[Results, Step]:
        """Return the recorded step that ``source`` names, in this run's file or another, and that file."""
        results = self.file
        if results is None or source.file is not None:
            path = self.path if source.file is None else self.plan.base / source.file
            results = read_results(path, source.step)
        return results, results.step(source.step)

    def drop_step(self, name: str) -> None:
        """Remove a step, finished or not, so that it can be computed anew."""
        drop_steps(self.path, [name])
        self._forget(name)

    def keep_step(self, step: Step) -> None:
        """Take in what the results file holds of a step now."""
        if self.file is not None:
            self.file = _hold(self.file, {**self.file.steps, step.name: step})

    def _forget(self, name: str) -> None:
        if self.file is not None:
            self.file = _hold(self.file, {key: step for key, step in self.file.steps.items() if key != name})

    def open_step(
        self,
        step: PlannedStep[Any],
        step_format: StepFormat,
        meta: Mapping[str, Any],
        *,
        recorded: Step | None = None,
        kept: int = 0,
        capacity: int | None = None,
        at_once: bool = False,
    ) -> RowWriter:
        """Return the writer of a step's rows, with what every step says of itself added to ``meta``.

        The first ``kept`` rows of ``recorded`` stay. ``at_once``: the first point follows,
        and the file need not say before that the step has begun.
        """
        common = {
            "parameters": list(self.plan.model.parameters),
            "states": list(self.plan.model.states),
            "model": self.plan.model.name,
            "settings": self.plan.describe_settings(step),
        }
        options: dict[str, Any] = {"at_once": at_once} | ({} if capacity is None else {"capacity": capacity})
        return self.open_as(step.name, step_format, {**common, **meta}, recorded=recorded, kept=kept, **options)

    def open_as(self, name: str, step_format: StepFormat, meta: Mapping[str, Any], **options: Any) -> RowWriter:
        """Return the writer of a step's rows, ``meta`` being all that it says of itself."""
        self._forget(name)
        return self.make_writer(self.path, name, step_format, meta, closed=self.keep_step, **options)


def _hold(file: Results, steps: Mapping[str, Step]) -> Results:
    """Return what a file holds with these steps."""
    return replace(file, names=tuple(steps), steps=steps)
