"""What pictures look like: matplotlib's settings, colours, markers."""

from __future__ import annotations

from typing import Any

# Settings of matplotlib (rcParams). The salt makes the identifiers in an SVG the same each time.
SETTINGS: dict[Any, Any] = {
    "figure.constrained_layout.use": True,
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "font.size": 9.5,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "mathtext.default": "it",
    "mathtext.fontset": "dejavusans",
    "svg.hashsalt": "pddecont",
}
# Dots per inch of moving pictures: a frame is as wide as a page on a screen.
MOVING_DPI = 100
# Sizes of text in points, smaller than the axes' own.
TITLE_SIZE, LEGEND_SIZE, INNER_LEGEND_SIZE = 9.5, 8.5, 8.0
# Chosen by eye: alike in lightness, different in hue.
COLOURS = ("#1f5fa8", "#c2402f", "#2f8f5b", "#8a5fb0", "#b8860b", "#3b3b3b", "#3aa0b5", "#c45f96")
# Curves of special points in two parameters, by the kind of point.
CURVE_COLOURS = {
    "GR": "#c2402f",
    "LP": "#1f5fa8",
    "PD": "#2f8f5b",
    "TR": "#8a5fb0",
    "VS": "#b8860b",
    "UF": "#3b3b3b",
    "GD": "#3aa0b5",
    "CS": "#c45f96",
    "GS": "#a0522d",
    "SS": "#556b2f",
    "AS": "#4b4b9b",
}
# Of special equilibria.
EQUILIBRIUM_COLOURS = {"LP": "#39a9dd", "HB": "#e07b1e", "BE": "#8a8a3a"}
OTHER_CURVE_COLOUR = "0.45"
# As matplotlib names them: (4, 1, 0) is a star of four points.
MARKERS: dict[str, Any] = {
    "GR": "o",
    "LP": "s",
    "BP": "x",
    "PD": "^",
    "TR": "*",
    "VS": "D",
    "MC": "+",
    "GD": (5, 0, 0),
    "CS": (3, 0, 30),
    "GS": (3, 0, 90),
    "SS": (4, 0, 20),
    "AS": (7, 1, 0),
    "EP": "|",
    "UF": "v",
    "HB": "H",
    "CP": "P",
    "R1": "1",
    "R2": "2",
    "R3": "3",
    "R4": "4",
    "HH": (8, 1, 0),
    "FF": "X",
    "FT": ">",
    "PT": "<",
    "TT": "p",
    "GG": "h",
    "GL": "d",
    "GP": (4, 1, 0),
    "GT": (6, 1, 0),
    "EQ": "o",
    "BE": (3, 1, 0),
    "BT": (3, 1, 180),
    "ZH": (4, 1, 45),
    "GH": (6, 2, 0),
}
# Of kinds of special points that are not listed, somebody's own among them.
OTHER_MARKER = "8"
# Markers without an inside to fill.
LINES_ONLY = ("x", "+", "|", "1", "2", "3", "4", (6, 2, 0))


def make_palette(n: int) -> list[str]:
    """Return ``n`` colours, no two alike: :data:`COLOURS`, then the bright ones of a rainbow."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    more = max(0, n - len(COLOURS))
    return [*COLOURS, *(to_hex(colormaps["turbo"](0.15 + 0.6 * (k + 0.5) / more)) for k in range(more))][:n]


def find_marker(kind: str) -> Any:
    """Return the marker of a kind of special point, as matplotlib names it."""
    return MARKERS.get(kind, OTHER_MARKER)


def find_curve_colour(kind: str, of_equilibria: bool = False) -> str:
    """Return the colour of a curve by the kind of special point that it follows."""
    return (EQUILIBRIUM_COLOURS if of_equilibria else CURVE_COLOURS).get(kind, OTHER_CURVE_COLOUR)
