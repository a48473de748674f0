"""Doing one step of a run, or what is left of it to do."""

from __future__ import annotations

import json
from typing import Any

from pddecont.errors import ResultsError
from pddecont.results import Step, compact_step
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.execution.accuracy import choose_settings
from pddecont.steps.registry import list_step_kinds


def do_step(context: Context, step: PlannedStep[Any]) -> None:
    """Do a step, or what is left of it to do."""
    kind = list_step_kinds()[step.kind]
    context.reporter.step(step.name, step.kind)
    recorded = None if context.file is None else context.file.steps.get(step.name)
    step = choose_settings(context, step, None if recorded is None else recorded.meta.get("choice"))
    if recorded is not None:
        _check_same_settings(context, step, recorded)
        if recorded.done:
            if not recorded.compact:
                context.keep_step(compact_step(context.path, step.name))
            context.reporter.done("done already")
            return
        if not kind.resumes:
            context.drop_step(step.name)
            recorded = None
    kind.load()(context, step, recorded)


def _check_same_settings(context: Context, step: PlannedStep[Any], recorded: Step) -> None:
    now, then = context.plan.describe_settings(step), recorded.meta.get("settings")
    if then is None or _drop_nulls(json.loads(then)) != _drop_nulls(json.loads(now)):
        raise ResultsError(
            f"step '{step.name}' of {context.path} was computed with other settings; give --overwrite or another -o"
        )


def _drop_nulls(data: Any) -> Any:
    """Return settings without what is not given: which keys a step may have is no part of them."""
    if isinstance(data, dict):
        return {key: _drop_nulls(value) for key, value in data.items() if value is not None}
    return [_drop_nulls(value) for value in data] if isinstance(data, list) else data
