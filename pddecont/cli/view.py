"""``pddecont view``."""

from __future__ import annotations

from pathlib import Path

import click

from pddecont.cli.console import say
from pddecont.cli.report import write_page


@click.command("view")
@click.argument("files", type=click.Path(), nargs=-1, required=True, metavar="FILE...")
def command(files: tuple[str, ...]) -> None:
    """Show results files in a browser: the page of 'pddecont report', in a temporary file."""
    import tempfile
    import webbrowser

    folder = Path(tempfile.mkdtemp(prefix="pddecont-"))
    path = folder / f"{Path(files[-1]).stem}.html"
    try:
        write_page(files, path)
    except BaseException:
        folder.rmdir()
        raise
    # The browser reads the page after this command has ended, so it stays.
    say(f"page: {path}")
    if not webbrowser.open(path.as_uri()):
        say("no browser could be started; open the page in one")
