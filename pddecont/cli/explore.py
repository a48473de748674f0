"""``pddecont explore``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pddecont.cli.completers import complete_assignment, complete_effect, complete_file, complete_state
from pddecont.cli.console import print_json, say
from pddecont.errors import printable


@click.command("explore")
@click.argument("model", shell_complete=complete_file)
@click.option(
    "--over",
    "ranges",
    multiple=True,
    required=True,
    metavar="NAME=LOW:HIGH",
    help="Parameter and its range; a second one for curves of special points.",
    shell_complete=complete_assignment,
)
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="Results file  [default: MODEL_explore.h5]"
)
@click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a parameter; may be repeated.",
    shell_complete=complete_assignment,
)
@click.option(
    "--without",
    multiple=True,
    metavar="EFFECT",
    help="Leave an effect of the model out; may be repeated.",
    shell_complete=complete_effect,
)
@click.option(
    "--box",
    "boxes",
    multiple=True,
    metavar="STATE=LOW:HIGH",
    help="Where motions start  [default: what a few cover]",
    shell_complete=complete_state,
)
@click.option("--transient", metavar="TIME", help="Longest time to settle  [default: from a few motions]")
@click.option("--starts", type=click.IntRange(1), metavar="N", help="Motions to find attractors by.  [default: 32]")
@click.option("--check", type=click.IntRange(0), metavar="N", help="Motions compared at the end.  [default: 64]")
@click.option("--max-branches", type=click.IntRange(1), metavar="N", help="Most branches begun.  [default: 40]")
@click.option("--depth", type=click.IntRange(0), metavar="N", help="Most period doublings in a row.  [default: 4]")
@click.option("--time", type=click.FloatRange(0, min_open=True), metavar="S", help="End in order after S seconds.")
@click.option("--resume", is_flag=True, help="Go on with an output that exists.")
@click.option("--overwrite", is_flag=True, help="Replace results that exist.")
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True, metavar="N", help="As in 'run'.")
@click.option("--scheduler", metavar="ADDRESS", help="As in 'run'.")
@click.option("--watch", is_flag=True, help="As in 'run'.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors and warnings.")
@click.option("--json", "as_json", is_flag=True, help="Write one JSON document on what was computed.")
def command(
    model: str,
    ranges: tuple[str, ...],
    output: Path | None,
    assignments: tuple[str, ...],
    without: tuple[str, ...],
    boxes: tuple[str, ...],
    resume: bool,
    overwrite: bool,
    workers: int,
    scheduler: str | None,
    watch: bool,
    quiet: bool,
    as_json: bool,
    time: float | None,
    max_branches: int | None,
    **limits: Any,
) -> None:
    """Compute the whole diagram of MODEL over a parameter: all that is found, followed both ways.

    MODEL is a path, '-' for standard input, or the name of a shipped model; of its run block delay, mesh and monitors
    count, and not the steps. The results are ordinary steps, which 'plot', 'report', 'info' and 'export' show.
    """
    from pddecont.api import EXPLORATION, plan_exploration
    from pddecont.cli.run import compute_shown, read_assignment
    from pddecont.runfile import Overrides
    from pddecont.steps import Budget
    from pddecont.tables import describe_exploration_lines

    if resume and overwrite:
        raise click.UsageError("--resume and --overwrite exclude each other")
    settings = {name: value for name, value in limits.items() if value is not None}
    overrides = Overrides(tuple(map(read_assignment, assignments)), without)
    over, box = (dict(map(_read_range, texts)) for texts in (ranges, boxes))
    checked = plan_exploration(model, over, overrides, box=box, **settings)
    path = output or Path("run.h5" if model == "-" else f"{Path(model).stem}_explore.h5")
    results = compute_shown(
        checked,
        path,
        quiet=quiet or as_json,
        watch=watch,
        resume=resume,
        overwrite=overwrite,
        workers=workers,
        scheduler=scheduler,
        budget=Budget(time, max_branches),
    )
    if as_json:
        print_json({"output": str(path), **results.summary()})
    elif not quiet:
        for line in describe_exploration_lines(results[EXPLORATION].step):
            click.echo(printable(line))
        say(f"results: {path}")


def _read_range(text: str) -> tuple[str, list[str | float]]:
    from pddecont.runfile import as_number

    name, equals, limits = text.partition("=")
    low, colon, high = limits.partition(":")
    if not (equals and colon and name.strip() and low.strip() and high.strip()):
        raise click.UsageError(f"expected NAME=LOW:HIGH, found '{text}'")
    return name.strip(), [as_number(low.strip()), as_number(high.strip())]
