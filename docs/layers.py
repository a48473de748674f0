"""Draw docs/images/layers.svg, which folder imports which, from the import statements: ``make layers``.

Boxes stand above all that they import. An arrow that follows from others is left out, and so are ``errors``, ``memo``,
``output``, ``reasons`` and ``version``, which import nothing above them, and imports for type checkers alone. Dashed:
imported inside functions alone, when it is first used.
"""

from __future__ import annotations

import ast
import itertools
import random
from collections.abc import Iterator
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, PathPatch
from matplotlib.path import Path as Line
from scipy.optimize import linprog

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "pddecont"
PICTURE = ROOT / "docs" / "images" / "layers.svg"
# Single modules that nearly all import, which import at most one another, and those that only lead to others.
FOUNDATION = ("errors", "memo", "output", "reasons", "version")
ENTRIES = ("__init__", "__main__")
# Boxes of their own inside other folders.
OWN = ("steps.execution",)
# How many orders are tried, and how often each is mended.
N_STARTS, N_SWEEPS = 300, 6
# Widths of boxes and of places where a line passes, and heights.
BOX, PASS, HEIGHT, ROW = 1.5, 0.3, 0.42, 1.0
# Inches.
SCALE = 0.85
# Colours of boxes: those that compute, and all others.
COMPUTING, OTHER = "#eaf4e6", "#e8eef7"
NUMBERS = (
    "bifurcation",
    "stability",
    "equilibrium",
    "orbit",
    "simulate",
    "delay",
    "codegen",
    "collocation",
    "continuation",
    "intervals",
)

Edge = tuple[str, str]


def box_of(module: str) -> str:
    """Return the box in which a module of the package is drawn."""
    inner = module.removeprefix("pddecont.")
    return next((own for own in OWN if inner.startswith(own)), inner.partition(".")[0])


def read_imports() -> dict[Edge, bool]:
    """Return which box imports which, and whether when it is imported itself (else only inside functions)."""
    found: dict[Edge, bool] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        own = box_of(".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"))
        if own in (*ENTRIES, "pddecont"):
            continue
        for module, at_once in list_imports(ast.parse(path.read_text())):
            if module.startswith("pddecont.") and (other := box_of(module)) not in (own, *FOUNDATION):
                found[own, other] = found.get((own, other), False) or at_once
    return found


def list_imports(node: ast.AST, at_once: bool = True) -> Iterator[tuple[str, bool]]:
    """Yield each module that is imported, and whether at once; none that only type checkers import."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and isinstance(child.test, ast.Name) and child.test.id == "TYPE_CHECKING":
            continue
        if isinstance(child, ast.ImportFrom) and child.module:
            of_package = child.module == "pddecont"
            names = [f"pddecont.{alias.name}" for alias in child.names] if of_package else [child.module]
            yield from ((name, at_once) for name in names)
        elif isinstance(child, ast.Import):
            yield from ((alias.name, at_once) for alias in child.names)
        yield from list_imports(child, at_once and not isinstance(child, ast.FunctionDef))


def find_layers(edges: dict[Edge, bool]) -> dict[str, int]:
    """Return the layer of each box: one above the highest that it imports, 0 at the bottom."""
    names = sorted({name for edge in edges for name in edge})
    layers = dict.fromkeys(names, 0)
    for _ in names:
        for above, below in edges:
            layers[above] = max(layers[above], layers[below] + 1)
    if any(layers[above] <= layers[below] for above, below in edges):
        raise SystemExit("the imports go round in a circle")
    return layers


def leave_out_implied(edges: dict[Edge, bool]) -> dict[Edge, bool]:
    """Return the edges that do not follow from others."""
    below: dict[str, set[str]] = {}
    for above, other in edges:
        below.setdefault(above, set()).add(other)

    def reaches(start: str, end: str) -> bool:
        return end in below.get(start, ()) or any(reaches(between, end) for between in below.get(start, ()))

    return {(a, b): at_once for (a, b), at_once in edges.items() if not any(reaches(c, b) for c in below[a] if c != b)}


def split_long_edges(edges: dict[Edge, bool], layers: dict[str, int]) -> tuple[dict[Edge, list[str]], list[list[str]]]:
    """Return each edge's way from layer to layer, and what is in each layer: boxes, and places where lines pass."""
    rows: list[list[str]] = [[] for _ in range(max(layers.values()) + 1)]
    for name, layer in layers.items():
        rows[layer].append(name)
    ways = {}
    for above, below in edges:
        places = {layer: f"|{above}|{below}|{layer}" for layer in range(layers[above] - 1, layers[below], -1)}
        for layer, place in places.items():
            rows[layer].append(place)
        ways[above, below] = [above, *places.values(), below]
    return ways, rows


def arrange(ways: dict[Edge, list[str]], rows: list[list[str]]) -> list[list[str]]:
    """Return the rows in an order in which few lines cross, and lines are short."""
    links = sorted({link for way in ways.values() for link in itertools.pairwise(way)})
    beside: dict[str, list[str]] = {}
    for above, below in links:
        beside.setdefault(above, []).append(below)
        beside.setdefault(below, []).append(above)
    dice, best, least = random.Random(1), rows, (np.inf, np.inf)
    for _ in range(N_STARTS):
        tried = [dice.sample(sorted(row), len(row)) for row in rows]
        for _ in range(N_SWEEPS):
            for row, other in [*itertools.pairwise(tried), *itertools.pairwise(tried[::-1])]:
                sort_by_neighbours(other, row, beside)
            crossings = count_crossings(links, tried)
            if crossings <= least[0]:
                length = place(links, tried)[1]
                if (crossings, length) < least:
                    best, least = [list(row) for row in tried], (crossings, length)
    return best


def sort_by_neighbours(row: list[str], other: list[str], beside: dict[str, list[str]]) -> None:
    """Put a row in the order of what it is joined to in the row above or below it."""
    at = {name: k / max(1, len(other) - 1) for k, name in enumerate(other)}
    means = {}
    for k, name in enumerate(row):
        near = [at[n] for n in beside.get(name, ()) if n in at]
        means[name] = sum(near) / len(near) if near else k / max(1, len(row) - 1)
    row.sort(key=lambda name: means[name])


def count_crossings(links: list[Edge], rows: list[list[str]]) -> int:
    """Return how often lines cross."""
    at = {name: (i, k) for i, row in enumerate(rows) for k, name in enumerate(row)}
    ends = [(at[above], at[below][1]) for above, below in links]
    pairs = itertools.combinations(ends, 2)
    return sum(a[0] == c[0] and (a[1] - c[1]) * (b - d) < 0 for (a, b), (c, d) in pairs)


def place(links: list[Edge], rows: list[list[str]]) -> tuple[dict[str, float], float]:
    """Return where everything stands from left to right in rows of an order, and how far lines lean in all."""
    names = [name for row in rows for name in row]
    number = {name: k for k, name in enumerate(names)}
    n, m = len(names), len(links)
    # Lines that only pass are held straight. The unknowns are the places, and how far each line leans.
    cost = np.concatenate([np.zeros(n), [1.0 + 2.0 * (a[0] == "|") + 2.0 * (b[0] == "|") for a, b in links]])
    left, right = [], []
    for k, (a, b) in enumerate(links):
        for sign in (1.0, -1.0):
            line = np.zeros(n + m)
            line[number[a]], line[number[b]], line[n + k] = sign, -sign, -1.0
            left.append(line)
            right.append(0.0)
    for row in rows:
        for a, b in itertools.pairwise(row):
            line = np.zeros(n + m)
            line[number[a]], line[number[b]] = 1.0, -1.0
            left.append(line)
            right.append(-(width(a) + width(b)) / 2 - 0.25)
    solved = linprog(cost, np.array(left), np.array(right), bounds=(0, None))
    return {name: float(solved.x[k]) for name, k in number.items()}, float(solved.fun)


def width(name: str) -> float:
    """Return the width of a box, or of the place where a line passes."""
    return PASS if name[0] == "|" else BOX


def draw(edges: dict[Edge, bool]) -> Figure:
    """Return the picture."""
    shown = leave_out_implied(edges)
    ways, rows = split_long_edges(shown, find_layers(edges))
    rows = arrange(ways, rows)
    links = sorted({link for way in ways.values() for link in itertools.pairwise(way)})
    x, _ = place(links, rows)
    y = {name: i * ROW for i, row in enumerate(rows) for name in row}
    low, high = min(x.values()) - BOX / 2 - 0.1, max(x.values()) + BOX / 2 + 0.1
    bottom, top = -1.0, (len(rows) - 1) * ROW + HEIGHT
    figure = Figure(figsize=(SCALE * (high - low), SCALE * (top - bottom)))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(low, high), ylim=(bottom, top), aspect="equal")
    axes.axis("off")
    for edge, way in ways.items():
        draw_line(axes, way, x, y, shown[edge])
    for name in x:
        if name[0] != "|":
            draw_box(axes, name, x[name], y[name])
    words = f"{', '.join(FOUNDATION)}: below all of them"
    axes.text((low + high) / 2, -0.7, words, ha="center", va="center", fontsize=9)
    return figure


def draw_line(axes: Axes, way: list[str], x: dict[str, float], y: dict[str, float], at_once: bool) -> None:
    """Draw an arrow along its way: upright past the boxes of a layer, leaning between layers."""
    points, codes = [(x[way[0]], y[way[0]] - HEIGHT / 2)], [Line.MOVETO]
    for name in way[1:]:
        end = y[name] + HEIGHT / 2
        middle = (points[-1][1] + end) / 2
        points += [(points[-1][0], middle), (x[name], middle), (x[name], end)]
        codes += [Line.CURVE4] * 3
        if name[0] == "|":
            points.append((x[name], y[name] - HEIGHT / 2))
            codes.append(Line.LINETO)
    style = {"color": "#555555", "linewidth": 1.0, "linestyle": "-" if at_once else "--"}
    axes.add_patch(PathPatch(Line(points, codes), fill=False, **style))
    x_tip, y_tip = points[-1]
    head = {"arrowstyle": "-|>", "color": "#555555", "lw": 1.0}
    axes.annotate("", (x_tip, y_tip), (x_tip, y_tip + 0.06), arrowprops=head)


def draw_box(axes: Axes, name: str, x: float, y: float) -> None:
    """Draw the box of a folder, or of a module."""
    colour = COMPUTING if name in NUMBERS else OTHER
    corner = (x - BOX / 2, y - HEIGHT / 2)
    style = "round,pad=0,rounding_size=0.08"
    axes.add_patch(FancyBboxPatch(corner, BOX, HEIGHT, boxstyle=style, fc=colour, ec="#333333", lw=1.0))
    axes.text(x, y, name.replace(".", "/"), ha="center", va="center", fontsize=10)


if __name__ == "__main__":
    matplotlib.rcParams.update({"svg.hashsalt": "layers", "svg.fonttype": "path"})
    picture = draw(read_imports())
    picture.savefig(PICTURE, metadata={"Date": None}, facecolor="white")
