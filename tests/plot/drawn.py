"""What an axes shows, as plain data."""

from __future__ import annotations

import numpy as np


def lines(axes, style):
    """Return the (x, y) arrays of the lines of a style; marks of single points are none."""
    return [line.get_xydata() for line in axes.lines if line.get_linestyle() == style and len(line.get_xydata()) > 1]


def coloured(axes, style="-"):
    """Return the colours of lines of a style in the order drawn."""
    return [line.get_color() for line in axes.lines if line.get_linestyle() == style and len(line.get_xydata()) > 1]


def span(xy):
    """Return the first and last x of a line."""
    return float(xy[0, 0]), float(xy[-1, 0])


def legend(figure):
    """Return {text: colour} of the figure's legend."""
    if not figure.legends:
        return {}
    [box] = figure.legends
    return {
        text.get_text(): getattr(h, "get_color", h.get_facecolor if hasattr(h, "get_facecolor") else None)()
        for text, h in zip(box.get_texts(), box.legend_handles, strict=True)
    }


def texts(axes):
    """Return the annotations of an axes by their text."""
    return {t.get_text(): t for t in axes.texts}


def boxes(axes):
    """Return the extents of all annotations in pixels, shape (n, 4)."""
    axes.figure.draw_without_rendering()
    renderer = axes.figure._get_renderer()
    return np.array([_text_box(t, renderer) for t in axes.texts])


def _text_box(text, renderer):
    from matplotlib.text import Text

    return Text.get_window_extent(text, renderer).extents
