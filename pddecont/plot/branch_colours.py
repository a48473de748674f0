"""Colours and line styles of branches, and what a legend says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.branch_lines import MARKS
from pddecont.plot.branch_parts import INNER_KINDS, Family, LineStyle, find_family, split_branch
from pddecont.plot.legend import make_line_handle, shorten_list
from pddecont.plot.several_files import list_file_names, split_name
from pddecont.plot.special_points import read_kind
from pddecont.plot.style import COLOURS
from pddecont.results import Step
from pddecont.tables import find_signature, shorten_signature

if TYPE_CHECKING:
    from matplotlib.artist import Artist

# Of lines in a legend that stand for a style, whatever the colour.
NEUTRAL = "0.35"


@dataclass(frozen=True)
class BranchColours:
    """The colours of some branches: ``of_parts`` by (step's name, family), ``in_legend`` with the texts beside them."""

    of_parts: Mapping[tuple[str, Family], str]
    in_legend: Sequence[tuple[str, str]]

    def make_handles(self) -> list[Artist]:
        """Return the legend's handles."""
        return shorten_list([make_line_handle(text, color=colour) for text, colour in self.in_legend])


def assign_branch_colours(steps: Sequence[Step], palette: Sequence[str] = COLOURS) -> BranchColours:
    """Return the colours of branches.

    Of several files these differ in colour; of one, families; where there is only one, steps; where there is only one
    step too, there is no legend.
    """
    files = list_file_names(steps)
    if len(files) > 1:
        by_file = {file: palette[k % len(palette)] for k, file in enumerate(files)}
        of_files = {(s.name, part.family): by_file[split_name(s)[0]] for s in steps for part in split_branch(s)}
        return BranchColours(of_files, list(by_file.items()))
    pairs = list(dict.fromkeys((step.name, part.family) for step in steps for part in split_branch(step)))
    families = list(dict.fromkeys(family for _, family in pairs))
    by_step = len(families) == 1
    distinct: list[Any] = [step.name for step in steps] if by_step else families
    colours = {item: palette[k % len(palette)] for k, item in enumerate(distinct)}
    of_parts = {pair: colours[pair[0] if by_step else pair[1]] for pair in pairs}
    if len(distinct) == 1:
        return BranchColours(of_parts, [])
    names = [step.name for step in steps] if by_step else name_families(steps, families)
    return BranchColours(of_parts, list(zip(names, colours.values(), strict=True)))


def assign_kind_colours(steps: Sequence[Step], palette: Sequence[str] = COLOURS) -> BranchColours:
    """Return the colours of many branches: of equilibria, and of orbits by their number of periods."""
    pairs = list(dict.fromkeys((step.name, part.family) for step in steps for part in split_branch(step)))
    kinds = sorted({0 if family.rests else family.n_periods for _, family in pairs})
    colours = {kind: palette[k % len(palette)] for k, kind in enumerate(kinds)}
    of_parts = {(name, family): colours[0 if family.rests else family.n_periods] for name, family in pairs}
    names = {kind: f"orbits of {kind} period{'s'[: kind - 1]}" if kind else "equilibria" for kind in kinds}
    return BranchColours(of_parts, [(names[kind], colours[kind]) for kind in kinds])


def name_families(steps: Sequence[Step], families: Sequence[Family]) -> list[str]:
    """Return how a legend calls each family: its signature as it is first found, and its periods where they differ."""
    signatures: dict[Family, str] = {}
    for step in steps:
        for part in split_branch(step):
            own = (int(i) for i in part.rows if find_family(step, int(i)) == part.family)
            signatures.setdefault(part.family, shorten_signature(find_signature(step, next(own, int(part.rows[0])))))
    orbits = [family for family in families if not family.rests]
    several = len({family.n_periods for family in orbits}) > 1
    names = {f: f"{f.n_periods} period{'s' if f.n_periods > 1 else ''}" if several else "" for f in orbits}
    names = {f: ", ".join(text for text in (signatures[f], names[f]) if text) or "no events" for f in orbits}
    if len(orbits) == 1 < len(families):
        names = {orbits[0]: "orbits"}
    several_modes = len(families) - len(orbits) > 1
    names |= {f: f"equilibria, {f.signature}" if several_modes else "equilibria" for f in families if f.rests}
    return [names[family] for family in families]


def make_style_handles(steps: Sequence[Step], color: str = NEUTRAL, **style: Any) -> list[Artist]:
    """Return the legend's handles for line styles, or marks of points on no branch; none where every one is solid."""
    parts = [(step.format.has_branch, part) for step in steps for part in split_branch(step)]
    used = {part.style for _, part in parts}
    if used == {LineStyle.SOLID}:
        return []
    known = np.concatenate([_find_known(step) for step in steps])
    solid = "stable" if known.all() else "stable, or not known" if known.any() else "admissible"
    rest = all(part.family.rests for _, part in parts if part.style == LineStyle.DOTTED)
    dotted = "virtual" if rest else "not admissible"
    words = {LineStyle.SOLID: solid, LineStyle.DASHED: "unstable", LineStyle.DOTTED: dotted}
    if not any(has_branch for has_branch, _ in parts) and all(part.family.rests for _, part in parts):
        return [make_line_handle(words[ls], color=color, ls="", **mark) for ls, mark in MARKS.items() if ls in used]
    return [make_line_handle(text, color=color, ls=ls, **style) for ls, text in words.items() if ls in used]


def _find_known(step: Step) -> NDArray[np.bool_]:
    """Return for each point, but those where stability changes, whether it is known, shape (n,)."""
    inner = [i for i in range(len(step)) if read_kind(step, i) in INNER_KINDS]
    return np.asarray(step.points.get("stable", np.full(len(step), -1))[inner] >= 0)
