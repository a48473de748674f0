"""What a shell offers: shipped models, and of the file that stands before on the line its steps, labels and parameters.

Names come from files that anybody may have written, and shells do things with some signs: only names of letters,
digits and a few signs that mean nothing to a shell are offered. A file that cannot be read offers nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    from pddecont.model import Model
    from pddecont.results import Results, Step

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]
_OFFERED = re.compile(r"[\w.+-]+")
# What commands call the file, or files, that they read.
FILE_PARAMETERS = ("file", "files", "model")


def complete_file(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the shipped models and runs that go on as ``incomplete`` begins.

    Where there are none, the shell looks among files.
    """
    from pddecont.data import list_shipped

    names = sorted(name for name in list_shipped() if name.startswith(incomplete))
    there = bool(incomplete) and bool(names)
    return [CompletionItem(name) for name in names] if there else [CompletionItem(incomplete, type="file")]


def complete_step(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the steps of a results file."""
    return _offer((name for results in _read_results(context) for name in results.steps), incomplete)


def complete_label(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the labels of a results file's points, those of the chosen steps where some were chosen."""
    return _offer((label for step in _list_steps(context) for label in step.labels if label), incomplete)


def complete_axis(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return what axes show of the steps of a results file: parameters, monitors, other numbers and states."""
    from pddecont.plot import list_columns

    steps = [step for step in _list_steps(context) if {"parameters", "monitors"} <= set(step.meta)]
    return _offer((name for step in steps for name in (*list_columns(step), *step.meta["states"])), incomplete)


def complete_planned_step(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the steps that a run file, or a model's run block, asks for."""
    steps = (_read_document(context).get("run") or _read_document(context)).get("steps") or []
    return _offer((str(step.get("name", "")) for step in steps if isinstance(step, dict)), incomplete)


def complete_effect(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the effects that a model may be left without."""
    return _offer(_read_model(context, lambda model: model.effects), incomplete)


def complete_assignment(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the parameters of a model, each with the sign that a value goes after."""
    return [
        CompletionItem(f"{item.value}=")
        for item in _offer(_read_model(context, lambda model: model.parameters), incomplete)
    ]


def complete_state(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the states of a model, each with the sign that its range goes after."""
    return [
        CompletionItem(f"{item.value}=")
        for item in _offer(_read_model(context, lambda model: model.states), incomplete)
    ]


def complete_style(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the styles of matplotlib; where there are none, the shell looks among files."""
    from pddecont.plot import list_styles

    return _offer(list_styles(), incomplete) or [CompletionItem(incomplete, type="file")]


def _offer(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    kept = (name for name in dict.fromkeys(names) if name.startswith(incomplete) and _OFFERED.fullmatch(name))
    return [CompletionItem(name) for name in kept]


def _list_files(context: click.Context) -> Sequence[str]:
    """Return the files that stand before; click leaves them in ``args`` where the option's value is still missing."""
    found = next((value for name in FILE_PARAMETERS if (value := context.params.get(name))), context.args)
    return [found] if isinstance(found, str) else [str(file) for file in found if not str(file).startswith("-")]


def _read_results(context: click.Context) -> list[Results]:
    from pddecont.errors import PddecontError
    from pddecont.results import read_results

    found = []
    for file in _list_files(context):
        try:
            found.append(read_results(file))
        except (PddecontError, OSError):
            continue
    return found


def _list_steps(context: click.Context) -> list[Step]:
    chosen = context.params.get("steps") or context.params.get("step") or ()
    names = [chosen] if isinstance(chosen, str) else chosen
    return [
        step
        for results in _read_results(context)
        for step in results.steps.values()
        if step.name in (names or [step.name])
    ]


def _read_document(context: click.Context) -> dict[str, Any]:
    """Return the contents of the run file or model that is named; nothing where there is none that can be read."""
    from pddecont.errors import PddecontError
    from pddecont.runfile import load_document

    for file in _list_files(context):
        try:
            return dict(load_document(file).data)
        except (PddecontError, OSError, TypeError):
            continue
    return {}


def _read_model(context: click.Context, choose: Callable[[Model], Iterable[str]]) -> Iterable[str]:
    """Return what is chosen of the model that is named, alone or by a run file; nothing where it cannot be read."""
    from pddecont.errors import PddecontError
    from pddecont.model import parse_model
    from pddecont.runfile import is_run_file, load_document
    from pddecont.steps import load_run_plan

    for file in _list_files(context):
        try:
            document = load_document(file)
            model = load_run_plan(document).model if is_run_file(document) else parse_model(document)[0]
            return list(choose(model))
        except (PddecontError, OSError):
            continue
    return []
