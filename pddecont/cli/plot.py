"""``pddecont plot``."""

from __future__ import annotations

from pathlib import Path

import click

from pddecont.cli.console import say

KINDS = ("diagram", "plane", "manifold", "multipliers", "orbit", "profile", "trajectory", "sweep", "basin", "precision", "distance",
         "animate")  # fmt: skip


@click.command("plot")
@click.argument("file", type=click.Path())
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path),
              help="Picture: .png, .svg or .pdf; of animate .gif or .mp4  [default: FILE's name, .png or .gif]")  # fmt: skip
@click.option("--step", "steps", multiple=True, metavar="STEP",
              help="Step to draw; may be repeated  [default: the last branch and all in the same parameters]")  # fmt: skip
@click.option("--view", "kind", type=click.Choice(KINDS), help="What to draw  [default: what suits the step]")
@click.option("-x", "x", metavar="NAME", help="Horizontal axis: a parameter, monitor or state.")
@click.option("-y", "y", metavar="NAME", help="Vertical axis (in a manifold the second parameter).")
@click.option("-z", "z", metavar="NAME",
              help="What a manifold shows upwards: a monitor, or a parameter where -x and -y are states or delayed values.")
@click.option("--label", "labels", multiple=True, metavar="LABEL", help="Point whose orbit is shown; may be repeated.")
@click.option("--index", "indices", multiple=True, type=click.IntRange(0), help="The same by index; may be repeated.")
@click.option("--style", metavar="STYLE", help="A matplotlib style sheet, by file or by name, over the program's own look.")
@click.option("--list", "only_list", is_flag=True, help="Draw nothing: list the steps and the views that each can give.")
def command(file: str, output: Path | None, steps: tuple[str, ...], kind: str | None, x: str | None, y: str | None, z: str | None,
            labels: tuple[str, ...], indices: tuple[int, ...], style: str | None, only_list: bool) -> None:  # fmt: skip
    """Draw what results file FILE holds.

    \b
      diagram      branches over their parameter, with phase plots of special points
      plane        curves of special points in two parameters
      manifold     branches and such curves in three dimensions
      multipliers  Floquet multipliers in the complex plane
      orbit        orbits in the plane of two states
      profile      states over one period
      trajectory   a simulation
      sweep        a brute-force diagram: returns over a parameter, with branches in it and Lyapunov exponents below it
      basin        the map of basins of attraction
      precision    error against CPU time and unknowns, with slopes
      distance     how far chains are from the delay equation, over N
      animate      the orbit moving along a branch, beside a mark on the diagram
    """  # noqa: D301 - click's mark for text that is not wrapped anew
    from pddecont.plot.choice import View, views_of
    from pddecont.plot.figure import draw
    from pddecont.results.reader import read_results

    results = read_results(file)
    if only_list:
        for step in map(results.step, steps or results.steps):
            click.echo(f"{step.name}  {step.kind}  {', '.join(views_of(step)) or 'nothing to draw yet'}")
        return
    path = output or Path(Path(file).stem + (".gif" if kind == "animate" else ".png"))
    draw(results, View(kind, steps, x, y, z, labels, indices), path, style)
    say(f"picture: {path}")
