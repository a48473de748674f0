"""Telling how a step ended."""

from __future__ import annotations

from typing import Any

from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.tables import describe_done


def report_done(context: Context, step: PlannedStep[Any]) -> None:
    """Tell who listens what a recorded step came to."""
    context.reporter.done(describe_done(context.read_step(step.name)))
