"""The ``sweep`` step: brute-force diagrams over one or two parameters."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import sympy
from numpy.typing import NDArray
from pydantic import Field

from pddecont.errors import suggest
from pddecont.model import Identifier, Strict
from pddecont.results import SWEEP
from pddecont.runfile import Holding, ParameterFormula, StepInput
from pddecont.steps.fields import Grid, Range
from pddecont.steps.kind import Sharing, StepKind
from pddecont.steps.motion import Initial, Start, resolve_start
from pddecont.steps.settling import Settling, SettlingSettings, list_section_names, resolve_grid, resolve_settling

Array = NDArray[np.float64]
# What one step may hold at most.
MAX_MOTIONS = 2_000_000


class Scatter(Strict):
    """Initial states at random."""

    number: int = Field(ge=1, le=100_000, description="how many")
    seed: int = Field(1, ge=0, description="start of the random numbers")
    box: dict[Identifier, Range] = Field(min_length=1, description="lowest and highest value of each state that varies")
    spread: Literal["same", "sobol"] = Field(
        "same",
        description=(
            "same: the same initial states at every parameter point of the grid; sobol: parameters and initial states "
            "together are points of a Sobol sequence, as many as the grid has points"
        ),
    )


class Sweep(Settling):
    """Where motions settle over a grid of one or two parameters."""

    over: dict[Identifier, Grid] = Field(
        min_length=1, max_length=2, description="parameters: lowest, highest, how many values"
    )
    initial: list[Initial] = Field(
        default_factory=lambda: [Initial.model_validate({})],
        min_length=1,
        description=("initial states; each is tried at every parameter"),
    )
    random: Scatter | None = Field(None, description="more initial states, at random")
    carry: Literal["none", "up", "down", "both"] = Field(
        "none",
        description=(
            "go on from where the motion stood at the parameter before, upwards, downwards or both; the first "
            "parameter is carried along"
        ),
    )


@dataclass(frozen=True, eq=False)
class ScatterSettings:
    """Initial states at random in a box: their number, the seed, lowest and highest value of states by index.

    Where they are ``spread`` the parameters are too, and each point has initial states of its own.
    """

    number: int
    seed: int
    box: Mapping[int, tuple[ParameterFormula, ParameterFormula]]
    spread: bool


@dataclass(frozen=True, eq=False)
class SweepSettings:
    """What a sweep step does.

    Attributes
    ----------
    grids
        Values of each parameter that varies, by name.
    starts
        Where motions start at every parameter point (none: at random alone).
    scattered_from
        The start that those at random vary.
    history
        The expressions in t before the start that the step gives; None for the model's.
    ways
        Directions in which motions are carried along: +1 up, -1 down; none where they are not.
    """

    parameters: Array
    settling: SettlingSettings
    grids: Mapping[str, Array]
    starts: tuple[Start, ...]
    scattered_from: Start
    scatter: ScatterSettings | None
    history: tuple[sympy.Expr, ...] | None
    ways: tuple[int, ...]


def resolve_sweep(given: StepInput[Sweep]) -> SweepSettings:
    """Return what a sweep step does; note what is wrong with it."""
    body = given.body
    settling = resolve_settling(given, body)
    names = list(body.over)
    settable = [given.check_settable(("over", name), name) for name in names]
    if all(settable):
        for ends in itertools.product(*(body.over[name][:2] for name in names)):
            corner = {name: given.evaluate(("over", name), end) for name, end in zip(names, ends, strict=True)}
            given.check_durations(("over",), {**given.values, **corner})
    grids = resolve_grid(given, body.over)
    scattered = body.random.number if body.random else 0
    motions = math.prod(int(n) for _, _, n in body.over.values()) * (scattered + len(body.initial))
    if motions > MAX_MOTIONS:
        given.add_error(("over",), f"{motions} motions in one step; at most {MAX_MOTIONS}: make it several steps")
    starts = []
    for i, initial in enumerate(body.initial):
        starts.append(resolve_start(given, ("initial", i), initial))
        histories = initial.history, body.initial[0].history
        if any(isinstance(h, Mapping) for h in histories) and histories[0] != histories[1]:
            given.add_error(
                ("initial", i),
                "all initial states of a sweep share one history; give other histories a step of their own",
            )
    scatter = None if body.random is None else _resolve_scatter(given, body.random)
    alone = scatter is not None and "initial" not in body.model_fields_set
    ways = {"none": (), "up": (1,), "down": (-1,), "both": (1, -1)}[body.carry]
    own, history = () if alone else tuple(starts), starts[0].history
    return SweepSettings(given.parameters, settling, grids, own, starts[0], scatter, history, ways)


def _resolve_scatter(given: StepInput[Sweep], random: Scatter) -> ScatterSettings:
    states, box = given.model.states, {}
    for name, limits in random.box.items():
        here = ("random", "box", name)
        if name not in states:
            given.add_error(here, f"'{name}' is not a state{suggest(name, states)}", key=True)
            continue
        low, high = (given.parse_formula((*here, k), text) for k, text in enumerate(limits))
        ends = [given.evaluate((*here, k), text) for k, text in enumerate(limits)]
        if ends[0] > ends[1]:
            given.add_error(here, f"the range is empty: {ends[0]:g} is not below {ends[1]:g}")
        box[list(states).index(name)] = (low, high)
    spread = random.spread == "sobol"
    if spread and given.body.carry != "none":
        given.add_error(("carry",), "points of a Sobol sequence have no order to be carried along; leave 'carry' out")
    # Which random number a state gets does not depend on the order in which they are named.
    return ScatterSettings(random.number, random.seed, dict(sorted(box.items())), spread)


def list_sweep_names(body: Sweep) -> Iterator[Any]:
    """Return the texts of a sweep step whose names the model must have."""
    yield from list_section_names(body)
    yield from () if body.random is None else body.random.box


def list_sweep_modes(body: Sweep) -> Iterator[str]:
    """Return the modes that motions are put into."""
    yield from body.stick.values()
    yield from (initial.mode for initial in body.initial if initial.mode is not None)


SWEEP_STEP = StepKind(
    name="sweep",
    fields=Sweep,
    resolve=resolve_sweep,
    format=SWEEP,
    run="pddecont.steps.execution.sweep:run_sweep",
    sharing=Sharing.POOL,
    resumes=True,
    holds=Holding.ATTRACTORS,
    list_names=list_sweep_names,
    list_modes=list_sweep_modes,
    list_sticks=lambda body: body.stick.items(),
    list_varied=lambda body: body.over,
)
