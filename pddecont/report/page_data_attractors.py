"""Attractors of sweeps and basins: their classes of motion, their returns, and who goes where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pddecont.plot import make_palette
from pddecont.report.packed_arrays import ArrayPacker
from pddecont.results import Step
from pddecont.tables import find_attractors, name_motion, read_label_map

# Of motions that came to no attractor.
NO_ATTRACTOR, NO_COLOUR = "no attractor", "#d9d9d9"


def choose_colours(sweeps: Sequence[Step]) -> dict[str, str]:
    """Return a colour for each class of motions of some sweeps; motions that came to no attractor are grey."""
    rows = [(step, int(row)) for step in sweeps for row in find_attractors(step)]
    names = list(dict.fromkeys(_name_class(step, row, by_row=False) for step, row in rows))
    return dict(zip(names, _list_colours(names), strict=True))


def describe_attractors(packer: ArrayPacker, step: Step, colours: Mapping[str, str]) -> dict[str, Any]:
    """Return of each attractor, in the order of the step's main table, its class and its returns to the section.

    Classes of sweeps have the ``colours`` that are given. ``n_returns`` says how many returns each has.

    Of basins ``map`` holds the attractor of each initial state, line by line over ``x`` and ``y``.
    """
    rows = [int(row) for row in find_attractors(step)]
    by_row = step.kind == "basin"
    names = [_name_class(step, row, by_row) for row in rows]
    classes = names if by_row else list(dict.fromkeys(names))
    numbers = list(range(len(rows))) if by_row else [classes.index(name) for name in names]
    returns = [step.orbit(row)["returns"] for row in rows]
    shown: dict[str, Any] = {
        "classes": classes,
        "colours": _list_colours(classes) if by_row else [colours[name] for name in classes],
        "class": packer.add(numbers, "<u4"),
        "n_returns": packer.add([len(values) for values in returns], "<u4"),
        "returns": packer.add(np.vstack([np.empty((0, len(step.meta["states"]))), *returns]).T, "<f8"),
    }
    if not by_row:
        return shown
    labels = read_label_map(step)
    return shown | {
        "over": [str(name) for name in step.meta["over"]],
        "x": packer.add(step.meta["x"], "<f8"),
        "y": packer.add(step.meta["y"][: len(labels)], "<f8"),
        "map": packer.add(labels, "<u4"),
    }


def _name_class(step: Step, row: int, by_row: bool) -> str:
    """Return the class of a motion in words, with its label where each attractor is a class by itself."""
    if not step.labels[row]:
        return NO_ATTRACTOR
    return f"{step.labels[row]}: {name_motion(step, row)}" if by_row else name_motion(step, row)


def _list_colours(classes: Sequence[str]) -> list[str]:
    """Return a colour each; motions that came to no attractor are grey."""
    left = iter(make_palette(sum(name != NO_ATTRACTOR for name in classes)))
    return [NO_COLOUR if name == NO_ATTRACTOR else next(left) for name in classes]
