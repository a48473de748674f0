"""A figure that notebooks show, whether or not they have switched on matplotlib's own pictures."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from pddecont.plot.style_sheet import apply_style


class ShownFigure(Figure):
    """A matplotlib figure that draws itself as a PNG where it stands at the end of a notebook's cell."""

    def _repr_png_(self) -> bytes:
        with apply_style(), io.BytesIO() as stream:
            self.savefig(stream, format="png", dpi=self.dpi)
            return stream.getvalue()
