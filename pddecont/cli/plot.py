"""``pddecont plot``."""

from __future__ import annotations

from pathlib import Path

import click

from pddecont.cli.completers import complete_axis, complete_label, complete_step, complete_style
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
@click.argument("files", type=click.Path(), nargs=-1, required=True, metavar="FILE...")
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Picture: .png, .svg or .pdf; of animate .gif or .mp4  [default: the last FILE's name, .png or .gif]",
)
@click.option(
    "--step",
    "steps",
    multiple=True,
    metavar="STEP",
    help="Step to draw; may be repeated  [default: the last branch and all in the same parameters]",
    shell_complete=complete_step,
)
@click.option("--view", "view", type=ViewName(), help="What to draw  [default: what suits the step]")
@click.option(
    "-x", "x", metavar="NAME", help="Horizontal axis: a parameter, monitor or state.", shell_complete=complete_axis
)
@click.option(
    "-y",
    "y",
    metavar="NAME",
    help="Vertical axis: a parameter, monitor or state (in a manifold the second parameter).",
    shell_complete=complete_axis,
)
@click.option(
    "-z",
    "z",
    metavar="NAME",
    help="What a manifold shows upwards: a monitor, or a parameter where -x and -y are states or delayed values.",
    shell_complete=complete_axis,
)
@click.option(
    "--label",
    "labels",
    multiple=True,
    metavar="LABEL",
    help="Point whose orbit, multipliers or roots are shown; may be repeated.",
    shell_complete=complete_label,
)
@click.option("--index", "indices", multiple=True, type=click.IntRange(0), help="The same by index; may be repeated.")
@click.option(
    "--size",
    metavar="SIZE",
    help="Width, such as 85mm, or width and height, such as 170x60mm  [default: what the view needs]",
)
@click.option(
    "--style",
    metavar="STYLE",
    help="A matplotlib style sheet, by file or by name, over the program's own look.",
    shell_complete=complete_style,
)
@click.option(
    "--list", "only_list", is_flag=True, help="Draw nothing: list the steps and the views that each can give."
)
def command(
    files: tuple[str, ...],
    output: Path | None,
    steps: tuple[str, ...],
    view: str | None,
    x: str | None,
    y: str | None,
    z: str | None,
    labels: tuple[str, ...],
    indices: tuple[int, ...],
    size: str | None,
    style: str | None,
    only_list: bool,
) -> None:
    """Draw what results file FILE holds; several files in one picture where the view shows several steps."""
    from pddecont.plot import VIEWS, ViewRequest, list_views, read_size, save_picture
    from pddecont.results import read_results

    found = [read_results(file) for file in files]
    if only_list:
        for results in found:
            before = f"{results.path}: " if len(found) > 1 else ""
            for step in map(results.step, steps or results.steps):
                names = [view.name for view in list_views(step)]
                click.echo(f"{before}{step.name}  {step.kind}  {', '.join(names) or 'nothing to draw yet'}")
        return
    is_moving = view is not None and VIEWS[view].is_moving
    path = output or Path(Path(files[-1]).stem + (".gif" if is_moving else ".png"))
    asked = ViewRequest(view, steps, x, y, z, labels, indices)
    save_picture(found, asked, path, style, read_size(size) if size else None)
    say(f"picture: {path}")
