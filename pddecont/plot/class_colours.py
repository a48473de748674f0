"""Classes of motion in a brute-force diagram: their order, their colours and, where there are many, their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.style import COLOURS, make_palette
from pddecont.results import Step
from pddecont.tables import name_motion

# Classes of motion that have a colour of their own, the most frequent ones; the others are grey.
MAX_CLASSES = 24
OTHER_COLOUR = "0.6"
# Colours can be told apart by themselves up to so many; of more each class has a number, too.
MAX_UNNUMBERED = len(COLOURS)
# A class that is not found over so many usual gaps between its places is not one range there.
FAR = 3.0


@dataclass(frozen=True)
class ClassColours:
    """The colour of each class of motion by name, and its number in the picture where classes have one.

    They stand in the order of their periods, those without a period last, of one period the most frequent first.
    """

    colours: Mapping[str, str]
    numbers: Mapping[str, int]

    def list_legend(self) -> list[tuple[str, str]]:
        """Return what a legend lists, (text, colour): those that are grey together, with their number, come last."""
        grey = [name for name, colour in self.colours.items() if colour == OTHER_COLOUR]
        alone = [(self._describe(name), colour) for name, colour in self.colours.items() if name not in grey]
        if not grey:
            return alone
        return [*alone, (grey[0] if len(grey) == 1 else f"{len(grey)} other classes", OTHER_COLOUR)]

    def _describe(self, name: str) -> str:
        return f"{self.numbers[name]}: {name}" if name in self.numbers else name


def assign_class_colours(steps: Sequence[Step]) -> ClassColours:
    """Return the colours of the classes of motion of some sweeps."""
    counts: dict[str, int] = {}
    periods: dict[str, float] = {}
    for step in steps:
        for i in list_attractor_rows(step):
            name = name_motion(step, i)
            counts[name] = counts.get(name, 0) + 1
            periods.setdefault(name, float(step.points["period"][i]) or np.inf)
    frequent = sorted(counts, key=lambda name: (-counts[name], name))[:MAX_CLASSES]
    own = dict(zip(frequent, make_palette(len(frequent)), strict=True))
    ordered = sorted(counts, key=lambda name: (periods[name], -counts[name], name))
    shown = [name for name in ordered if name in own]
    numbers = {name: k for k, name in enumerate(shown, 1)} if len(shown) > MAX_UNNUMBERED else {}
    return ClassColours({name: own.get(name, OTHER_COLOUR) for name in ordered}, numbers)


def list_attractor_rows(step: Step) -> list[int]:
    """Return the rows that are attractors, not motions that failed."""
    return [i for i in range(len(step)) if step.labels[i]]


def find_middle(places: NDArray[np.float64]) -> int:
    """Return which of some places along an axis, shape (n,), lies in the middle of those that lie closest together."""
    order = np.argsort(places, kind="stable")
    gaps = np.diff(places[order])
    if not np.any(gaps > 0.0):
        return int(order[len(order) // 2])
    ends = np.flatnonzero(gaps > FAR * np.median(gaps[gaps > 0.0])) + 1
    runs = np.split(order, ends)
    longest = max(runs, key=len)
    return int(longest[len(longest) // 2])
