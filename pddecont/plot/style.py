"""One look for all pictures."""

from __future__ import annotations

from typing import Any

COLOURS = ("#1f5fa8", "#c2402f", "#2f8f5b", "#8a5fb0", "#b8860b", "#3b3b3b", "#3aa0b5", "#c45f96")
MARKERS: dict[str, Any] = {
    "GR": "o", "LP": "s", "BP": "x", "PD": "^", "TR": "*", "VS": "D", "EP": "|", "UF": "v",
    "CP": "P", "R1": "1", "R2": "2", "R3": "3", "R4": "4", "FF": "X", "FT": ">", "PT": "<", "TT": "p",
    "GG": "h", "GL": "d", "GP": (4, 1, 0), "GT": (6, 1, 0),
}  # fmt: skip
OTHER_MARKER = "8"
LINES_ONLY = ("x", "|", "1", "2", "3", "4")
# Curves of special points in two parameters.
KIND_COLOURS = {"GR": "#c2402f", "LP": "#1f5fa8", "PD": "#2f8f5b", "TR": "#8a5fb0", "VS": "#b8860b", "UF": "#3b3b3b"}
RC: Any = {
    "figure.constrained_layout.use": True, "figure.dpi": 110, "savefig.dpi": 160, "font.size": 9.5, "axes.grid": True,
    "grid.alpha": 0.25, "grid.linewidth": 0.6, "axes.spines.top": False, "axes.spines.right": False, "lines.linewidth": 1.6,
    "legend.frameon": False, "mathtext.default": "it", "mathtext.fontset": "dejavusans", "svg.hashsalt": "pddecont",
}  # fmt: skip
_GREEK = {"alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda", "mu", "nu", "xi", "pi", "rho",
          "sigma", "tau", "phi", "chi", "psi", "omega"}  # fmt: skip


def palette(n: int) -> list[str]:
    """Return ``n`` colours, no two alike: :data:`COLOURS`, then the bright ones of a rainbow."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    more = max(0, n - len(COLOURS))
    return [*COLOURS, *(to_hex(colormaps["turbo"](0.15 + 0.6 * (k + 0.5) / more)) for k in range(more))][:n]


def label(name: str) -> str:
    """Return a name as it is written in mathematics: ``tau_d`` with its Greek letter and index."""
    # In a file from somebody else a name may hold anything.
    name = name.replace("$", r"\$")
    if "(" in name:
        return name
    first, _, rest = name.partition("_")
    if "_" in rest or not (first in _GREEK or len(first) == 1):
        return name.replace("_", " ")
    body = f"\\{first}" if first in _GREEK else first
    # An index of several letters is a word.
    index = rest if len(rest) < 2 or rest.isdigit() else f"\\mathrm{{{rest}}}"
    return f"${body}_{{{index}}}$" if rest else f"${body}$"


def marker(kind: str) -> Any:
    """Return the marker of a kind of special point, as matplotlib names it."""
    return MARKERS.get(kind, OTHER_MARKER)
