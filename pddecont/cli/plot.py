"""``pddecont plot``."""

from __future__ import annotations

from pathlib import Path

import click

from pddecont.cli.console import say


class ViewName(click.Choice[str]):
    """The names of the views in the registry, which is loaded when they are asked for and not before."""

    def __init__(self) -> None:
        self.case_sensitive = True

    @property
    def choices(self) -> tuple[str, ...]:  # type: ignore[override]
        """The names, in the order of the registry."""
        from pddecont.plot import VIEWS

        return tuple(VIEWS)


class PlotCommand(click.Command):
    """A command whose help lists the views of the registry."""

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what the command does, then what each view shows."""
        from pddecont.plot import VIEWS

        super().format_help_text(ctx, formatter)
        width = max(map(len, VIEWS))
        formatter.write_paragraph()
        with formatter.indentation():
            for view in VIEWS.values():
                formatter.write(f"{'':>{formatter.current_indent}}  {view.name:<{width}}  {view.description}\n")


@click.command("plot", cls=PlotCommand)
@click.argument("file", type=click.Path())
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Picture: .png, .svg or .pdf; of animate .gif or .mp4  [default: FILE's name, .png or .gif]",
)
@click.option(
    "--step",
    "steps",
    multiple=True,
    metavar="STEP",
    help="Step to draw; may be repeated  [default: the last branch and all in the same parameters]",
)
@click.option("--view", "view", type=ViewName(), help="What to draw  [default: what suits the step]")
@click.option("-x", "x", metavar="NAME", help="Horizontal axis: a parameter, monitor or state.")
@click.option(
    "-y", "y", metavar="NAME", help="Vertical axis: a parameter, monitor or state (in a manifold the second parameter)."
)
@click.option(
    "-z",
    "z",
    metavar="NAME",
    help="What a manifold shows upwards: a monitor, or a parameter where -x and -y are states or delayed values.",
)
@click.option(
    "--label",
    "labels",
    multiple=True,
    metavar="LABEL",
    help="Point whose orbit, multipliers or roots are shown; may be repeated.",
)
@click.option("--index", "indices", multiple=True, type=click.IntRange(0), help="The same by index; may be repeated.")
@click.option(
    "--style", metavar="STYLE", help="A matplotlib style sheet, by file or by name, over the program's own look."
)
@click.option(
    "--list", "only_list", is_flag=True, help="Draw nothing: list the steps and the views that each can give."
)
def command(
    file: str,
    output: Path | None,
    steps: tuple[str, ...],
    view: str | None,
    x: str | None,
    y: str | None,
    z: str | None,
    labels: tuple[str, ...],
    indices: tuple[int, ...],
    style: str | None,
    only_list: bool,
) -> None:
    """Draw what results file FILE holds."""
    from pddecont.plot import VIEWS, ViewRequest, list_views, save_picture
    from pddecont.results import read_results

    results = read_results(file)
    if only_list:
        for step in map(results.step, steps or results.steps):
            names = [found.name for found in list_views(step)]
            click.echo(f"{step.name}  {step.kind}  {', '.join(names) or 'nothing to draw yet'}")
        return
    is_moving = view is not None and VIEWS[view].is_moving
    path = output or Path(Path(file).stem + (".gif" if is_moving else ".png"))
    save_picture(results, ViewRequest(view, steps, x, y, z, labels, indices), path, style)
    say(f"picture: {path}")
