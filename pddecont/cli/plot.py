"""``pddecont plot``."""

from __future__ import annotations

from pathlib import Path

import click

from pddecont.cli.console import say

KINDS = ("diagram", "orbit", "profile", "trajectory")


@click.command("plot")
@click.argument("file", type=click.Path())
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path),
              help="Picture: .png, .svg or .pdf  [default: FILE's name, .png]")  # fmt: skip
@click.option("--step", metavar="STEP", help="Step to draw  [default: the last branch, else orbit, else trajectory]")
@click.option("--view", "kind", type=click.Choice(KINDS), help="What to draw  [default: what suits the step]")
@click.option("-x", "x", metavar="NAME", help="Horizontal axis: a parameter, monitor or state.")
@click.option("-y", "y", metavar="NAME", help="Vertical axis: a parameter, monitor or state.")
@click.option("--label", "labels", multiple=True, metavar="LABEL", help="Point whose orbit is shown; may be repeated.")
@click.option("--index", "indices", multiple=True, type=click.IntRange(0), help="The same by index; may be repeated.")
def command(file: str, output: Path | None, step: str | None, kind: str | None, x: str | None, y: str | None,
            labels: tuple[str, ...], indices: tuple[int, ...]) -> None:  # fmt: skip
    """Draw what results file FILE holds: a bifurcation diagram, orbits, states over time."""
    from pddecont.plot.figure import View, draw
    from pddecont.results.reader import read_results

    results = read_results(file)
    path = output or Path(Path(file).stem + ".png")
    draw(results, View(kind, step, x, y, labels, indices), path)
    say(f"picture: {path}")
