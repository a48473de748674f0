"""``pddecont explain``."""

from __future__ import annotations

import sys
import textwrap
from dataclasses import asdict

import click

from pddecont.cli.console import print_json

# Letters of a line.
WIDTH = 100


@click.command("explain")
@click.argument("words", nargs=-1, metavar="[MESSAGE]...")
@click.option("--json", "as_json", is_flag=True, help="Write one JSON document.")
def command(words: tuple[str, ...], as_json: bool) -> None:
    """Say why this program printed MESSAGE, and what to do then.

    MESSAGE is an error, a warning or how a branch ended, as it was printed or a part of it; without one it is read from
    the standard input: pddecont run MODEL 2>&1 | pddecont explain. All messages stand in docs/reference/messages.md.
    """
    from pddecont.data import explain_message

    message = " ".join(words) or sys.stdin.read()
    entries = explain_message(message)
    if as_json:
        print_json([asdict(entry) for entry in entries])
        return
    if not entries:
        raise click.ClickException("no message of this program is like this one; give more of it, as it was printed")
    for k, entry in enumerate(entries):
        click.echo(("\n" if k else "") + entry.subject)
        for name, text in (("cause", entry.cause), ("cure", entry.cure)):
            click.echo(textwrap.fill(f"{name}: {text}", WIDTH, initial_indent="  ", subsequent_indent="    "))
