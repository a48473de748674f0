"""``pddecont models``."""

from __future__ import annotations

import shutil
import sys
import textwrap

import click

from pddecont.cli.console import print_json

# Letters of a line that are always shown.
LEAST_WIDTH = 24


@click.command("models")
@click.argument("words", nargs=-1, metavar="[WORD]...")
@click.option("--json", "as_json", is_flag=True, help="Write one JSON document.")
def command(words: tuple[str, ...], as_json: bool) -> None:
    """List the models and run files that come with the program, one line each.

    With words, those whose name or line has them all. 'run', 'check', 'info' and 'explore' take the names.
    """
    from pddecont.data import describe_shipped, find_shipped_folders

    found = []
    for folder, sort in zip(find_shipped_folders(), ("model", "run"), strict=False):
        for file in sorted(folder.glob("*.yaml")):
            row = {"name": file.stem, "sort": sort, "what": describe_shipped(file)}
            if all(word.lower() in f"{row['name']} {row['what']}".lower() for word in words):
                found.append(row)
    if as_json:
        print_json(found)
        return
    width = max((len(row["name"]) for row in found), default=0)
    for row in found:
        line = f"{row['what']}{' (a run file)' if row['sort'] == 'run' else ''}"
        click.echo(f"{row['name']:<{width}}  {_fit(line, width + 2)}")


def _fit(line: str, indent: int) -> str:
    """Return a line as a terminal has room for it beside the names, cut between words; else all of it."""
    if not sys.stdout.isatty():
        return line
    return textwrap.shorten(line, max(LEAST_WIDTH, shutil.get_terminal_size().columns - indent), placeholder=" ...")
