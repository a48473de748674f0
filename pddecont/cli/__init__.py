"""The command line: one file a subcommand, loaded when it is called; the only code that prints or exits."""

from __future__ import annotations

import importlib
import os
from typing import Any

import click

from pddecont.cli.interrupt import end_on_signals
from pddecont.cli.version import show_version

# The matrices here are too small to share among threads; a user's own setting stands.
if "OMP_NUM_THREADS" not in os.environ:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

COMMANDS = {
    "models": "List the models that come with the program.",
    "new": "Write a model to start from.",
    "run": "Do the steps of a run file (or of a model's own run block).",
    "explore": "Compute the whole diagram of a model over a parameter.",
    "plot": "Draw what a results file holds.",
    "check": "Report every problem in model and run files.",
    "explain": "Say what a message means and what to do.",
    "info": "Say what is in a model, a run file or a results file.",
    "export": "Write a table of a results file.",
    "report": "Write one HTML page on results files.",
    "view": "Show results files in a browser.",
    "completion": "Print the script that lets a shell complete commands.",
}


class LazyGroup(click.Group):
    """A group that imports a subcommand only when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the subcommands' names, in the order they are used."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a subcommand, or None if there is none of this name."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(f"pddecont.cli.{cmd_name}").command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of subcommands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, callback=show_version, expose_value=False, help="Show the version and end.")
@click.option(
    "--verbose",
    is_flag=True,
    is_eager=True,
    help="With --version: the platform and every library, for reports of bugs.",
)
def group(verbose: bool) -> None:
    """Bifurcation analysis of piecewise-smooth delay differential equations.

    A system is described in a YAML file (delays, modes, events, resets); branches of its periodic orbits, their special
    points and pictures come out.

    \b
      pddecont run impact_oscillator        compute a shipped model's own run
      pddecont plot impact_oscillator.h5    draw it
    """  # noqa: D301 - click's mark for text that is not wrapped anew


def main(args: list[str] | None = None) -> Any:
    """Run the command line."""
    with end_on_signals(ends_process=args is None) as received:
        from pddecont.cli.console import run_and_exit

        return run_and_exit(lambda: group.main(args=args, prog_name="pddecont", standalone_mode=False), received)
