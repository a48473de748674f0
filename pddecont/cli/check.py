"""``pddecont check``."""

from __future__ import annotations

import click

from pddecont.cli.completers import complete_file
from pddecont.cli.console import Exit, say


@click.command("check")
@click.argument("files", nargs=-1, required=True, shell_complete=complete_file)
def command(files: tuple[str, ...]) -> int:
    """Report every problem in model and run FILES, with line and column; compute nothing."""
    from pddecont.errors import InputError
    from pddecont.model import explain_own_start, parse_model
    from pddecont.runfile import is_run_file, load_document
    from pddecont.steps import load_run_plan

    failed = False
    for file in files:
        try:
            document = load_document(file)
            if is_run_file(document) or document.data.get("run") is not None:
                plan = load_run_plan(document)
                warnings, what = plan.warnings, f"{len(plan.steps)} steps on model '{plan.model.name}'"
            else:
                model, found = parse_model(document)
                beyond = explain_own_start(model)
                found += [document.problem(("initial",), beyond, key=True)] if beyond else []
                warnings, what = tuple(found), f"model '{model.name}'"
        except InputError as exc:
            failed = True
            for problem in exc.problems:
                say(str(problem))
            continue
        for warning in warnings:
            say(f"{warning} (warning)")
        click.echo(f"{file}: no errors, {len(warnings)} warning(s); {what}")
    return Exit.WRONG_INPUT if failed else Exit.DONE
