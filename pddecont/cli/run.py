"""``pddecont run``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pddecont.cli.completers import complete_assignment, complete_effect, complete_file, complete_planned_step
from pddecont.cli.console import Progress, print_json, say

if TYPE_CHECKING:
    from pddecont.api import RunResults
    from pddecont.runfile import Plan


@click.command("run")
@click.argument("file", shell_complete=complete_file)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Results file  [default: the input's name, .h5]",
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
    "--accuracy",
    type=click.FloatRange(1e-11, 1, max_open=True),
    metavar="ERROR",
    help="Choose method, degree and mesh to meet this error on orbits.",
)
@click.option(
    "--only",
    metavar="STEP",
    help="Do this step only; with --resume into a file that holds the steps it starts from.",
    shell_complete=complete_planned_step,
)
@click.option("--until", metavar="STEP", help="Stop after this step.", shell_complete=complete_planned_step)
@click.option("--resume", is_flag=True, help="Go on with an output that exists.")
@click.option("--overwrite", is_flag=True, help="Replace results that exist.")
@click.option(
    "--workers",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    metavar="N",
    help="How many compute at once: points of sweeps and basins, directions of a branch, steps that do not depend on "
    "each other. The file is the same for any N.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers do so, such as tcp://host:8786.")
@click.option("--watch", is_flag=True, help="Keep a page beside the output that shows in a browser how it grows.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors and warnings.")
@click.option(
    "--json", "as_json", is_flag=True, help="Write one JSON document on what was computed to standard output."
)
def command(
    file: str,
    output: Path | None,
    assignments: tuple[str, ...],
    without: tuple[str, ...],
    accuracy: float | None,
    only: str | None,
    until: str | None,
    resume: bool,
    overwrite: bool,
    workers: int,
    scheduler: str | None,
    watch: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Do the steps of run file FILE, or of the run block of model FILE.

    FILE is a path, '-' for standard input, or the name of a shipped model or run.
    """
    from pddecont.api import plan
    from pddecont.runfile import Overrides

    if resume and overwrite:
        raise click.UsageError("--resume and --overwrite exclude each other")
    checked = plan(file, overrides=Overrides(tuple(map(read_assignment, assignments)), without, accuracy))
    has_name = file != "-" and not Path(checked.source).is_fifo()
    stem = Path(checked.source).stem if has_name else "run"
    path = output or Path(f"{stem}.h5")
    results = compute_shown(
        checked,
        path,
        quiet=quiet or as_json,
        watch=watch,
        resume=resume,
        overwrite=overwrite,
        only=only,
        until=until,
        workers=workers,
        scheduler=scheduler,
    )
    if as_json:
        result: dict[str, Any] = {"output": str(path), **results.summary()}
        print_json(result)
    elif not quiet:
        say(f"results: {path}")


def compute_shown(checked: Plan, path: Path, *, quiet: bool, watch: bool, **options: Any) -> RunResults:
    """Say what is suspicious in a plan, do it with its progress shown unless ``quiet``, and return its results.

    Whoever wants to ``watch`` has a page beside the results, which follows them.
    """
    from pddecont.api import compute
    from pddecont.cli.watch import Watch

    for warning in checked.warnings:
        say(f"{warning} (warning)")
    progress = Progress(quiet, len(checked.steps))
    watching = Watch(progress, path, path.with_suffix(".html")) if watch else None
    if watching is not None and not quiet:
        say(f"page: {watching.page.absolute().as_uri()} follows the run in a browser")
    try:
        return compute(checked, path, watching or progress, **options)
    finally:
        progress.stop()
        if watching is not None:
            watching.close()


def read_assignment(text: str) -> tuple[str, str]:
    """Return the name and the value of NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not value.strip():
        raise click.UsageError(f"--set takes NAME=VALUE, found '{text}'")
    return name.strip(), value.strip()
