"""What pictures look like: matplotlib's settings, colours, markers."""

from __future__ import annotations

from typing import Any

# Settings of matplotlib (rcParams). Text stays text in vector formats, to be searched and set in another font. The salt
# makes the identifiers in an SVG the same each time.
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
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}
# Over them in pictures as narrow as a journal's column.
JOURNAL_SETTINGS: dict[Any, Any] = {
    "font.size": 7.5,
    "lines.linewidth": 1.2,
    "savefig.dpi": 600,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
}
# Dots per inch of moving pictures: a frame is as wide as a page on a screen.
MOVING_DPI = 100
# Sizes of text, to that of the axes as matplotlib's words say; and as shares where a number is needed.
TITLE_SIZE, INNER_LEGEND_SIZE = "medium", "small"
LEGEND_SHARE, LABEL_SHARE = 0.9, 0.9
# Different in hue and, for those who print in grey, in lightness: of neighbours by 14 of 100 at the least (CIE L*).
COLOURS = ("#17508f", "#d1603d", "#1f7a4d", "#b48ad6", "#7a1f2b", "#d9a520", "#3b3b3b", "#45b3c9")
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


def scale_text(share: float) -> float:
    """Return a size of text in points: a share of that of the axes."""
    from matplotlib import rcParams

    return share * float(rcParams["font.size"])


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
