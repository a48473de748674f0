"""The plan of a run with all the kinds of steps that there are."""

from __future__ import annotations

from pddecont.model import Document
from pddecont.runfile import Overrides, Plan, load_plan
from pddecont.steps.registry import list_step_kinds


def load_run_plan(document: Document, overrides: Overrides | None = None) -> Plan:
    """Return the checked run that ``document`` describes; raise ModelError or RunError with all that is wrong."""
    return load_plan(document, list_step_kinds(), overrides)
