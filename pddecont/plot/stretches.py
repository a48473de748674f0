"""A branch as stretches that are drawn alike: of one family of orbits, stable or not, admissible or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.style import COLOURS
from pddecont.results.reader import Step
from pddecont.results.summary import short_signature, signature

SOLID, DASHED, DOTTED = "-", "--", ":"
# Points of these kinds lie inside a stretch; all other special points are where a property changes.
INNER = ("", "EP", "UF")


@dataclass(frozen=True)
class Family:
    """Orbits with one signature, up to where it begins, and one number of forcing periods."""

    signature: str
    n_periods: int


@dataclass(frozen=True)
class Stretch:
    """Consecutive points, by row, whose connecting lines look alike."""

    rows: NDArray[np.intp]
    style: str
    family: Family


def stretches(step: Step) -> list[Stretch]:
    """Return the stretches of a branch in order; neighbours share the point where they meet.

    A special point lies on a border and says nothing of the sides: a line that ends there looks as its other end says. Nothing
    joins points with different numbers of periods: what is recorded of a whole orbit jumps there.
    """
    order = step.order
    if len(order) == 1:
        return [Stretch(order, _style(step, order), family(step, int(order[0])))]
    looks = [_look(step, a, b) for a, b in pairwise(order)]
    result, start = [], 0
    for look, same in groupby(looks):
        n = len(list(same))
        if look is not None:
            result.append(Stretch(order[start : start + n + 1], *look))
        start += n
    return result


def _look(step: Step, a: int, b: int) -> tuple[str, Family] | None:
    if family(step, a).n_periods != family(step, b).n_periods:
        return None
    inner = np.array([i for i in (a, b) if step.labels[i][:2] in INNER], dtype=int)
    if len(inner):
        return _style(step, inner), family(step, int(inner[0]))
    ends = np.array([a, b])
    styles = {_style(step, ends[:1]), _style(step, ends[1:])}
    return next(s for s in (SOLID, DASHED, DOTTED) if s in styles), family(step, a)


def _style(step: Step, rows: NDArray[np.intp]) -> str:
    for name, style in (("admissible", DOTTED), ("stable", DASHED)):
        if name in step.points and np.any(step.points[name][rows] == 0):
            return style
    return SOLID


def family(step: Step, row: int) -> Family:
    """Return the family that a recorded orbit belongs to."""
    n_periods = int(step.points["n_periods"][row]) if "n_periods" in step.points else 1
    return Family(_first_rotation(signature(step, row)), n_periods)


@lru_cache(maxsize=1024)
def _first_rotation(text: str) -> str:
    names = text.split()
    return " ".join(min((names[i:] + names[:i] for i in range(len(names))), default=[]))


def colouring(steps: Sequence[Step], palette: Sequence[str] = COLOURS) -> tuple[dict[tuple[str, Family], str], list[Any]]:
    """Return a colour for each (step's name, family), and the handles of a legend.

    Families differ in colour; where there is only one, steps do; where there is only one step too, there is no legend.
    """
    from matplotlib.lines import Line2D

    pairs = list(dict.fromkeys((step.name, s.family) for step in steps for s in stretches(step)))
    kin = list(dict.fromkeys(f for _, f in pairs))
    by_step = len(kin) == 1
    things: list[Any] = [step.name for step in steps] if by_step else kin
    colours = {thing: palette[k % len(palette)] for k, thing in enumerate(things)}
    shown = {pair: colours[pair[0] if by_step else pair[1]] for pair in pairs}
    if len(things) == 1:
        return shown, []
    names = [step.name for step in steps] if by_step else family_names(steps, kin)
    return shown, [Line2D([], [], color=colours[t], label=name) for t, name in zip(things, names, strict=True)]


def family_names(steps: Sequence[Step], kin: Sequence[Family]) -> list[str]:
    """Return how a legend calls each family: its signature as first met, and its periods where they differ."""
    met: dict[Family, str] = {}
    for step in steps:
        for s in stretches(step):
            row = next((int(i) for i in s.rows if family(step, int(i)) == s.family), int(s.rows[0]))
            met.setdefault(s.family, short_signature(signature(step, row)))
    several = len({f.n_periods for f in kin}) > 1
    periods = [f"{f.n_periods} period{'s' if f.n_periods > 1 else ''}" if several else "" for f in kin]
    return [", ".join(t for t in (met[f], p) if t) or "no events" for f, p in zip(kin, periods, strict=True)]


def style_handles(steps: Sequence[Step]) -> list[Any]:
    """Return the legend's handles for line styles; none where every line is solid."""
    from matplotlib.lines import Line2D

    used = {s.style for step in steps for s in stretches(step)}
    if used == {SOLID}:
        return []
    known = np.concatenate([step.points.get("stable", np.full(len(step), -1)) >= 0 for step in steps])
    solid = "stable" if known.all() else "stable, or not computed" if known.any() else "admissible"
    words = {SOLID: solid, DASHED: "unstable", DOTTED: "not admissible"}
    return [Line2D([], [], color="0.35", ls=style, label=text) for style, text in words.items() if style in used]
