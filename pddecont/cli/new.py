"""``pddecont new``."""

from __future__ import annotations

from pathlib import Path

import click

from pddecont.cli.console import say

KINDS = {
    "impact": "an oscillator that hits a wall, with delayed feedback",
    "relay": "a relay that switches with a delay",
    "smooth": "a delay equation without events",
}


@click.command("new", epilog="Kinds: " + "; ".join(f"{name}, {what}" for name, what in KINDS.items()) + ".")
@click.argument("name", default="my_model")
@click.option(
    "--kind",
    type=click.Choice(list(KINDS)),
    default="impact",
    show_default=True,
    help="What the model is to start from.",
)
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="Model file  [default: NAME.yaml]"
)
def command(name: str, kind: str, output: Path | None) -> None:
    """Write a model with comments to start from, and a run that works as it stands."""
    from pddecont.data import write_starter

    path = output or Path(f"{name}.yaml")
    write_starter(kind, name, path)
    say(f"model: {path}; check it with 'pddecont check {path}', run it with 'pddecont run {path}'")
