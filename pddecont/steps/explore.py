"""The ``explore`` step: a whole diagram, in steps that it plans itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import Field

from pddecont.errors import suggest
from pddecont.model import Formula, Identifier
from pddecont.results import EXPLORE
from pddecont.runfile import StepInput
from pddecont.steps.continuation import StepSize
from pddecont.steps.fields import Range
from pddecont.steps.kind import Sharing, StepKind
from pddecont.steps.motion import Integration, resolve_method
from pddecont.steps.settling import Section, resolve_section

# Steps along a branch that motions between its points can be compared with.
LONGEST_STEP = 0.05


class Explore(Integration):
    """A whole diagram: attractors and equilibria, each followed, and what branches off; planned as further steps."""

    rtol: float = Field(1e-8, gt=0, lt=1, description="relative error allowed in a step of a motion")
    atol: float = Field(1e-10, gt=0, description="absolute error allowed in a step of a motion")
    over: dict[Identifier, Range] = Field(
        min_length=1, max_length=2, description="parameters: lowest and highest value; branches are in the first"
    )
    box: dict[Identifier, Range] = Field(
        default_factory=dict,
        description="lowest and highest value of states where motions start (default: what a few motions cover)",
    )
    transient: Formula | None = Field(
        None, description="longest time that a motion is given to settle (default: from a few motions)"
    )
    section: Section | None = Field(
        None, description="where returns are counted (default: the forcing, an event, or a level, from a few motions)"
    )
    starts: int = Field(32, ge=1, le=100_000, description="motions from which attractors are found at first")
    check: int = Field(64, ge=0, le=100_000, description="motions that are compared with all branches at the end")
    seed: int = Field(1, ge=0, description="start of the random numbers")
    max_period: int = Field(32, ge=1, le=256, description="longest period, in returns, that is told from no period")
    max_branches: int = Field(40, ge=1, le=10_000, description="most branches that are begun")
    depth: int = Field(4, ge=0, le=64, description="most period doublings one after another that are followed")
    step: StepSize = Field(default_factory=lambda: StepSize.model_validate({"max": LONGEST_STEP}))
    max_points: int = Field(300, ge=1, le=1_000_000, description="most points of a branch in each direction")


@dataclass(frozen=True, eq=False)
class ExploreSettings:
    """What an explore step does.

    Attributes
    ----------
    over
        Lowest and highest value of each parameter by name; branches are in the first.
    box
        Lowest and highest value of those states by name that the file says where motions start.
    transient
        The time to settle as it is written (None: to be found).
    body
        What the file says.
    """

    over: Mapping[str, tuple[float, float]]
    box: Mapping[str, tuple[float, float]]
    transient: str | float | None
    body: Explore


def resolve_explore(given: StepInput[Explore]) -> ExploreSettings:
    """Return what an explore step does; note what is wrong with it."""
    body, model = given.body, given.model
    resolve_method(given, body)
    for name in body.over:
        given.check_settable(("over", name), name)
    over = _resolve_ranges(given, "over", body.over)
    for name in body.box:
        if name not in model.states:
            given.add_error(("box", name), f"'{name}' is not a state{suggest(name, model.states)}", key=True)
    box = _resolve_ranges(given, "box", body.box)
    if body.transient is not None:
        longest = given.evaluate(("transient",), body.transient)
        if longest <= 0:
            given.add_error(("transient",), f"transient is {longest:g}; expected a positive time")
    if body.section is not None:
        resolve_section(given, body.section, is_default=False)
    return ExploreSettings(over, box, body.transient, body)


def _resolve_ranges(given: StepInput[Explore], key: str, ranges: Mapping[str, Range]) -> dict[str, tuple[float, float]]:
    found = {}
    for name, limits in ranges.items():
        low, high = (given.evaluate((key, name, k), text) for k, text in enumerate(limits))
        if not low < high:
            given.add_error((key, name), f"the range is empty: {low:g} is not below {high:g}")
        found[name] = (low, high)
    return found


def list_explore_names(body: Explore) -> Iterator[Any]:
    """Return the texts of an explore step whose names the model must have."""
    yield from body.box
    if body.section is not None and body.section.zero is not None:
        yield body.section.zero


EXPLORE_STEP = StepKind(
    name="explore",
    fields=Explore,
    resolve=resolve_explore,
    format=EXPLORE,
    run="pddecont.steps.execution.explore:run_explore",
    resumes=True,
    sharing=Sharing.POOL,
    plans=("sweep", "equilibrium", "orbit", "continue"),
    list_names=list_explore_names,
    list_modes=lambda body: body.stick.values(),
    list_sticks=lambda body: body.stick.items(),
    list_varied=lambda body: body.over,
)
