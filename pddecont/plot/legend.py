"""What stands in legends: handles of lines, marks and areas, and the legend below a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pddecont.plot.style import LEGEND_SHARE, scale_text

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend

MAX_COLUMNS = 3
# Things of one sort that a legend lists; of more it says how many there are.
MAX_LISTED = 12
# Lines of a legend that a figure's own size has room for, and the height of one more in inches, for letters of a point.
OWN_LINES, LINE_HEIGHT = 3, 1.7 / 72


def make_line_handle(label: str, **style: Any) -> Artist:
    """Return a legend's line (or mark, by ``marker`` and ``ls``) with its text."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **style)


def make_area_handle(label: str, **style: Any) -> Artist:
    """Return a legend's coloured area with its text."""
    from matplotlib.patches import Patch

    return Patch(label=label, **style)


def shorten_list(handles: Sequence[Artist], most: int = MAX_LISTED) -> list[Artist]:
    """Return at most so many handles of things of one sort; the last one counts those that are left out."""
    if len(handles) <= most:
        return list(handles)
    return [*handles[: most - 1], make_line_handle(f"and {len(handles) - most + 1} more", ls="")]


def add_legend(figure: Figure, handles: Sequence[Artist], max_columns: int | None = None) -> None:
    """Put a legend below all panels, in as many columns as fit (or ``max_columns``); without handles there is none.

    For a long one the figure becomes higher, and the panels keep their room.
    """
    if not handles:
        return
    columns = _choose_columns(figure, handles, max_columns or MAX_COLUMNS)
    n_lines = _count_lines(handles, columns)
    figure.set_figheight(figure.get_figheight() + LINE_HEIGHT * scale_text(LEGEND_SHARE) * max(0, n_lines - OWN_LINES))
    _put_legend(figure, handles, columns)


def _put_legend(figure: Figure, handles: Sequence[Artist], columns: int) -> Legend:
    return figure.legend(
        handles=list(handles), loc="outside lower center", ncols=columns, fontsize=scale_text(LEGEND_SHARE)
    )


def _choose_columns(figure: Figure, handles: Sequence[Artist], most: int) -> int:
    """Return the number of columns with which a legend is no wider than its figure, one if none is."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    for columns in range(min(most, len(handles)), 1, -1):
        legend = _put_legend(figure, handles, columns)
        width = legend.get_window_extent(renderer).width
        legend.remove()
        if width <= figure.bbox.width:
            return columns
    return 1


def _count_lines(handles: Sequence[Artist], columns: int) -> int:
    """Return how many lines of text the longest column has; columns are filled one after the other."""
    lines = [len(str(handle.get_label()).splitlines()) for handle in handles]
    rows = -(-len(lines) // columns)
    return max(sum(lines[k : k + rows]) for k in range(0, len(lines), rows))


def add_inner_legend(axes: Axes, size: str) -> None:
    """Put a legend into a panel, each text once."""
    handles, names = axes.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    axes.legend(unique.values(), unique.keys(), fontsize=size)
