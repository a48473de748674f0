"""Curves of special points in the plane of two parameters, with the side where the orbit lives on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.branch_colours import make_style_handles
from pddecont.plot.branch_lines import draw_parts
from pddecont.plot.branch_parts import find_family, split_branch
from pddecont.plot.columns import choose_plane, keep_comparable, list_free_parameters
from pddecont.plot.heights import choose_columns
from pddecont.plot.layouts import finish_figure, make_pair, make_panel_beside_orbits
from pddecont.plot.legend import add_legend, make_area_handle, make_line_handle
from pddecont.plot.point_labels import PointLabel, place_labels
from pddecont.plot.point_selection import select_orbits
from pddecont.plot.segment_colours import match_plane
from pddecont.plot.side_bands import draw_side_band
from pddecont.plot.side_counts import write_side_counts
from pddecont.plot.slopes import read_columns_with_slopes
from pddecont.plot.smooth_lines import smooth_branch
from pddecont.plot.special_points import CurveSort, find_special_rows, mark_special_points, name_apart, read_curve_sort
from pddecont.plot.style import find_marker
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.plot.views.diagram import draw_diagram
from pddecont.results import Results, Step
from pddecont.tables import describe_reason, find_signature, name_kind, shorten_signature

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# What the shaded side of a curve keeps, by the kind of point that the curve follows.
SIGNATURE_KEPT = "signature kept"
STABLE, FEWER_UNSTABLE = "stable", "fewer unstable multipliers"
SIDES = {"GR": SIGNATURE_KEPT, "VS": SIGNATURE_KEPT, "LP": "orbits exist", "PD": STABLE, "TR": STABLE}
SIDES |= dict.fromkeys(("CS", "GS", "SS", "AS"), SIGNATURE_KEPT)
OTHER_SIDE = "orbit kept"
# The same of equilibria.
IN_MODE, FEWER_ROOTS = "equilibrium in its mode", "fewer unstable roots"
EQUILIBRIUM_SIDES = {"LP": "equilibria exist", "HB": STABLE, "BE": IN_MODE}
# Between two marks along a curve, as a share of the picture's diagonal.
MARK_DISTANCE = 0.12
# What the numbers beside curves are.
NUMBERS = "numbers: unstable roots of the equilibria on that side"
# The kind of curves along which a user function is zero: which one tells them apart.
USER_FUNCTION = "UF"


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the curves in two parameters, with phase plots of points that were asked for.

    Beside them stands the diagram of branches in one parameter, if there are any among the steps.
    """
    branches, curves = ([s for s in steps if (len(list_free_parameters(s)) == 2) == is_curve] for is_curve in (0, 1))
    x, y = choose_plane(curves[::-1], request.x, request.y)
    if branches:
        return draw_with_response(branches, curves, x, y)
    rows = select_orbits(curves, request) if request.labels or request.indices else []
    figure, axes = make_panel_beside_orbits(curves, rows, match_plane(curves, rows))
    return finish_figure(figure, axes, *draw_plane(axes, curves, x, y))


def draw_with_response(branches: Sequence[Step], curves: Sequence[Step], x: str, y: str) -> Figure:
    """Return the diagram of branches in one parameter beside the plane of the curves that start from their points."""
    figure, (response, plane) = make_pair()
    own, of_branches = draw_diagram(response, branches, *choose_columns(branches))
    labels, of_curves = draw_plane(plane, curves, x, y)
    add_legend(figure, list({str(handle.get_label()): handle for handle in [*of_branches, *of_curves]}.values()))
    place_labels(response, own)
    place_labels(plane, labels)
    return figure


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the curves in the last one's two parameters, at its values of the others.

    When nobody asks for this view, for axes or points, the branches in one of these parameters that the file has before
    the first curve come first.
    """
    curves = keep_comparable(steps)
    if request.view or request.x or request.y or request.labels or request.indices:
        return curves
    found = list(results.steps.values())
    before = found[: min(found.index(curve) for curve in curves)]
    branches = [step for step in before if is_response(step, list_free_parameters(curves[-1]))]
    return [*(keep_comparable(branches) if branches else []), *curves]


def is_response(step: Step, parameters: Sequence[str]) -> bool:
    """Return whether a step is a branch in one of some parameters."""
    free = list_free_parameters(step)
    return step.format.has_branch and len(step) > 1 and len(free) == 1 and free[0] in parameters


def check_steps(steps: list[Step]) -> None:
    """Raise ResultsError if curves are in different parameters."""
    if len({frozenset(list_free_parameters(step)) for step in steps}) > 1:
        pairs = "; ".join(f"{step.name}: {', '.join(list_free_parameters(step))}" for step in steps)
        raise ResultsError(f"the curves are in different parameters ({pairs}); choose steps with the same pair")


def draw_plane(axes: Axes, steps: Sequence[Step], x: str, y: str) -> tuple[list[PointLabel], list[Artist]]:
    """Draw curves in two parameters, one colour a kind; a soft band marks the side that each point's ``side`` names.

    Curves of several kinds have their kinds' marks, so that they can be told apart without colours.

    Returns the labels of points of codimension two, which go in last, and the handles of the legend.
    """
    labels: dict[str, list[PointLabel]] = {}
    several = len({read_curve_sort(step) for step in steps}) > 1
    for step in steps:
        columns, slopes = read_columns_with_slopes(step, x, y)
        draw_parts(axes, step, columns, lambda step, _: read_curve_sort(step).colour, 1.8, slopes)
        if several:
            mark_curve(axes, smooth_branch(step, columns, slopes), read_curve_sort(step))
        labels[step.name] = mark_special_points(axes, step, columns[0], columns[1:])
    axes.margins(0.07)
    axes.autoscale_view()
    axes.set_xlim(axes.get_xlim())
    axes.set_ylim(axes.get_ylim())
    shaded = [step for step in steps if draw_side_band(axes, step, x, y, find_stable_side(step))]
    n_numbers = sum(write_side_counts(axes, step, x, y) for step in steps)
    axes.set_xlabel(format_axis_label(steps, x))
    axes.set_ylabel(format_axis_label(steps, y))
    handles = [*make_curve_handles(steps, marked=True), *make_style_handles(steps)]
    numbers = [make_line_handle(NUMBERS, ls="")] if n_numbers else []
    return name_apart(labels), [*handles, *_make_point_handles(steps), *_make_side_handles(shaded), *numbers]


def mark_curve(axes: Axes, line: NDArray[np.float64], sort: CurveSort) -> None:
    """Put the hollow marks of a curve's kind along its line, shape (2, n), at equal distances in the picture."""
    style: dict[str, Any] = make_hollow_mark(sort)
    axes.plot(*line, ls="", markevery=MARK_DISTANCE, zorder=2.5, **style)


def make_hollow_mark(sort: CurveSort) -> dict[str, Any]:
    """Return the style of a kind's hollow mark."""
    return {"marker": find_marker(sort.kind), "ms": 4.5, "mfc": "white", "mec": sort.colour, "mew": 0.9}


def find_stable_side(step: Step) -> NDArray[np.bool_] | None:
    """Return the points of a curve beside which orbits are stable on one side, shape (n_points,).

    These have no multiplier outside the unit circle, of equilibria no root to the right of the imaginary axis, beside
    the one, or the pair, that is on it. None where the side is no matter of stability, or these were not computed.
    """
    if _find_words(read_curve_sort(step)) != STABLE or "stable" not in step.points:
        return None
    stable = step.points["stable"]
    return np.asarray(stable == 1) if np.any(stable >= 0) else None


def make_curve_handles(steps: Sequence[Step], *, marked: bool = False) -> list[Artist]:
    """Return the legend's handles, one a sort of curve, in words; of several sorts ``marked`` ones have their marks."""
    sorts = _name_sorts(steps, _describe_curves)
    return [
        make_line_handle(
            words, color=sort.colour, lw=1.8, **(make_hollow_mark(sort) if marked and len(sorts) > 1 else {})
        )
        for sort, words in sorts.items()
    ]


def _name_sorts(steps: Sequence[Step], describe: Callable[[CurveSort, Sequence[Step]], str]) -> dict[CurveSort, str]:
    """Return words for each sort of curves; where orbits and equilibria have curves of one kind, these say whose."""
    groups: dict[CurveSort, list[Step]] = {}
    for step in steps:
        groups.setdefault(read_curve_sort(step), []).append(step)
    kinds = [sort.kind for sort in groups]
    return {
        sort: describe(sort, group)
        + (f" of {'equilibria' if sort.of_equilibria else 'orbits'}" if kinds.count(sort.kind) > 1 else "")
        for sort, group in groups.items()
    }


def _describe_curves(sort: CurveSort, steps: Sequence[Step]) -> str:
    """Return what the curves of a sort are in words, with what tells each from others of its kind."""
    words = name_kind(steps[0], sort.kind) or "curve"
    if sort.kind != USER_FUNCTION:
        return words
    names = dict.fromkeys(describe_reason(step.curve_reason) for step in steps)
    return f"{words} {', '.join(n for n in names if n)}".strip()


def _make_point_handles(steps: Sequence[Step]) -> list[Artist]:
    names = {step.kind_of(i): name_kind(step, step.kind_of(i)) for step in steps for i in find_special_rows(step)}
    return [
        make_line_handle(f"{kind}: {name}", color="black", ls="", marker=find_marker(kind), ms=5)
        for kind, name in sorted(names.items())
    ]


def _make_side_handles(steps: Sequence[Step]) -> list[Artist]:
    names = _name_sorts(steps, lambda sort, group: name_kind(group[0], sort.kind) or "curve")
    words = {sort: _describe_side(sort, [s for s in steps if read_curve_sort(s) == sort]) for sort in names}
    if len(words) > 1:
        words = {sort: f"{text} ({names[sort]})" for sort, text in words.items()}
    return [
        make_area_handle(f"shaded side: {text}", facecolor=sort.colour, alpha=0.25, linewidth=0)
        for sort, text in words.items()
    ]


def _find_words(sort: CurveSort) -> str:
    return (EQUILIBRIUM_SIDES if sort.of_equilibria else SIDES).get(sort.kind, OTHER_SIDE)


def _describe_side(sort: CurveSort, steps: Sequence[Step]) -> str:
    words = _find_words(sort)
    if words == STABLE and any(find_stable_side(step) is None for step in steps):
        return FEWER_ROOTS if sort.of_equilibria else FEWER_UNSTABLE
    families = {part.family for step in steps for part in split_branch(step)}
    if words not in (SIGNATURE_KEPT, IN_MODE) or len(families) != 1:
        return words
    row = next(i for i in range(len(steps[0])) if find_family(steps[0], i) in families)
    name = shorten_signature(find_signature(steps[0], row))
    if words == IN_MODE:
        return f"equilibrium in mode {name}"
    return f"signature {name} kept" if name else words


DRAWING = Drawing(draw_figure, choose_steps=choose_steps, check_steps=check_steps)
