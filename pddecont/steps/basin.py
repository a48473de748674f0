"""The ``basin`` step: a map of which attractor each of a grid of initial states leads to."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray
from pydantic import Field

from pddecont.errors import suggest
from pddecont.model import Identifier
from pddecont.results import BASIN
from pddecont.runfile import Holding, StepInput
from pddecont.simulate import InitialState
from pddecont.steps.fields import Grid
from pddecont.steps.kind import Sharing, StepKind
from pddecont.steps.motion import Initial, evaluate_start, resolve_start
from pddecont.steps.settling import Settling, SettlingSettings, list_section_names, resolve_grid, resolve_settling

Array = NDArray[np.float64]
# What one step may hold at most.
MAX_CELLS = 25_000_000


class Basin(Settling):
    """Which attractor each of a grid of initial states leads to."""

    over: dict[Identifier, Grid] = Field(
        min_length=2, max_length=2, description="two states: lowest, highest, how many values"
    )
    initial: Initial = Field(
        default_factory=lambda: Initial.model_validate({"history": "constant"}),
        description=("the other states, the mode and the history (constant unless given)"),
    )


@dataclass(frozen=True, eq=False)
class BasinSettings:
    """What a basin step does: the two states that vary, by name and index, their values, where motions start else."""

    parameters: Array
    settling: SettlingSettings
    names: tuple[str, str]
    places: tuple[int, int]
    x: Array
    y: Array
    start: InitialState
    history: tuple[sympy.Expr, ...] | None


def resolve_basin(given: StepInput[Basin]) -> BasinSettings:
    """Return what a basin step does; note what is wrong with it."""
    body, states = given.body, list(given.model.states)
    settling = resolve_settling(given, body)
    grids = resolve_grid(given, body.over)
    start = resolve_start(given, ("initial",), body.initial)
    cells = math.prod(int(n) for _, _, n in body.over.values())
    if cells > MAX_CELLS:
        given.add_error(("over",), f"{cells} initial states in one step; at most {MAX_CELLS}")
    for name in body.over:
        if name not in states:
            known = f"{suggest(name, states)} (states: {', '.join(states)})"
            given.add_error(("over", name), f"'{name}' is not a state{known}", key=True)
        elif name in body.initial.states:
            given.add_error(("initial", name), f"'{name}' varies over the grid and cannot be given too", key=True)
    x, y = body.over
    first, second = (states.index(name) if name in states else 0 for name in (x, y))
    at_start = evaluate_start(given, ("initial",), start)
    return BasinSettings(
        given.parameters, settling, (x, y), (first, second), grids[x], grids[y], at_start, start.history
    )


def list_basin_names(body: Basin) -> Iterator[Any]:
    """Return the texts of a basin step whose names the model must have."""
    yield from list_section_names(body)
    yield from body.over


def list_basin_modes(body: Basin) -> Iterator[str]:
    """Return the modes that motions are put into."""
    yield from body.stick.values()
    yield from [] if body.initial.mode is None else [body.initial.mode]


BASIN_STEP = StepKind(
    name="basin",
    fields=Basin,
    resolve=resolve_basin,
    format=BASIN,
    run="pddecont.steps.execution.basin:run_basin",
    sharing=Sharing.POOL,
    resumes=True,
    holds=Holding.ATTRACTORS,
    list_names=list_basin_names,
    list_modes=list_basin_modes,
    list_sticks=lambda body: body.stick.items(),
)
