"""Telling how a step ended."""

from __future__ import annotations

from typing import Any

from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.tables import describe_done


def report_done(context: Context, step: PlannedStep[Any]) -> None:
    """Tell who listens what a recorded step came to."""
    assert context.file is not None, "a step is done that has a file"
    context.reporter.done(describe_done(context.file.step(step.name)))
