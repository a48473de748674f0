"""What the steps of one run share: the plan, the results file, trajectories in memory, who hears how it goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results import Results, Step, StepWriter, read_results
from pddecont.runfile import Plan, PlannedStep, Source
from pddecont.steps.reporter import Reporter

if TYPE_CHECKING:
    from pddecont.results import StepFormat
    from pddecont.simulate import Trajectory, Workers

Array = NDArray[np.float64]


@dataclass(eq=False)
class Context:
    """State of a run in progress."""

    plan: Plan
    path: Path
    reporter: Reporter
    workers: Workers
    trajectories: dict[str, Trajectory] = field(default_factory=dict)

    def read_step(self, name: str) -> Step:
        """Return a step as the results file holds it now."""
        return read_results(self.path, name).step(name)

    def read_source(self, source: Source) -> tuple[Results, Step]:
        """Return the recorded step that ``source`` names, in this run's file or another, and that file."""
        results = read_results(self.path if source.file is None else self.plan.base / source.file, source.step)
        return results, results.step(source.step)

    def open_step(
        self,
        step: PlannedStep[Any],
        step_format: StepFormat,
        meta: Mapping[str, Any],
        *,
        recorded: Step | None = None,
        kept: int = 0,
        capacity: int | None = None,
    ) -> StepWriter:
        """Return the writer of a step's rows, with what every step says of itself added to ``meta``.

        The first ``kept`` rows of ``recorded`` stay.
        """
        common = {
            "parameters": list(self.plan.model.parameters),
            "states": list(self.plan.model.states),
            "model": self.plan.model.name,
            "settings": self.plan.describe_settings(step),
        }
        options: dict[str, Any] = {} if capacity is None else {"capacity": capacity}
        return StepWriter(
            self.path, step.name, step_format, {**common, **meta}, recorded=recorded, kept=kept, **options
        )
