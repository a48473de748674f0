"""The ``continue`` step: a branch of orbits or equilibria in one free parameter, a curve of special points in two."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pddecont.model import Formula, Identifier, SegmentName, Strict
from pddecont.orbit import Monitor
from pddecont.results import CONTINUE
from pddecont.runfile import From, Holding, StepInput, check_new_names, resolve_monitors
from pddecont.steps.fields import Range, StabilityChoice, Verify
from pddecont.steps.kind import Sharing, StepKind
from pddecont.steps.orbit import MultiplierSettings, resolve_multipliers, resolve_signature

# By how much of its range a start may lie outside it: rounding.
EDGE = 1e-9
WAYS = {"both": (-1, 1), "down": (-1,), "up": (1,)}


class StepSize(Strict):
    """Lengths of steps along a branch; a parameter's range counts as one, and so does the orbit's size."""

    initial: float = Field(0.02, gt=0, description="first step")
    min: float = Field(1e-6, gt=0, description="smallest step before the branch is given up")
    max: float = Field(0.1, gt=0, description="largest step")

    @model_validator(mode="after")
    def _check_order(self) -> StepSize:
        if not self.min <= self.initial <= self.max:
            raise PydanticCustomError("order", "expected min <= initial <= max", {})
        return self


class Continue(Strict):
    """Follow an orbit or an equilibrium in one free parameter, or a special point in two."""

    from_: From = Field(alias="from", description="an orbit, an equilibrium or a special point")
    free: list[Identifier] = Field(
        min_length=1, max_length=2, description="parameter to vary; two to follow a special point"
    )
    range: dict[Identifier, Range] = Field(description="lowest and highest value")
    step: StepSize = Field(default_factory=lambda: StepSize.model_validate({}))
    max_points: int = Field(500, ge=1, le=1_000_000, description="most points in each direction")
    direction: Literal["both", "up", "down"] = Field("both", description="which way the parameter goes at first")
    stability: StabilityChoice = False
    verify: Verify = None
    signature_change: Literal["follow", "stop"] = Field(
        "follow", description="what to do where an orbit grazes, a segment vanishes or a condition changes"
    )
    # None, so that settings of files that were made before say the same.
    period_halving: Literal["follow", "stop"] | None = Field(
        None,
        description="what to do where the two halves of an orbit become equal: go on with the single orbit (default)",
    )
    branch: Literal["same", "switch"] = Field(
        "same",
        description="switch: onto the other branch at a PD or BP point, onto the orbits born at an HB, GH or HH point",
    )
    signature: list[SegmentName] | None = Field(
        None, min_length=1, description=("segments that the orbit must have; at a GR point those after it")
    )
    detect: list[Identifier] | None = Field(
        None,
        description=(
            "kinds of special points that are looked for, such as [GR, LP] (default: all that there can be; []: none)"
        ),
    )
    events_along: dict[Identifier, Formula] = Field(
        default_factory=dict, description="user functions whose zeros are located"
    )


@dataclass(frozen=True, eq=False)
class ContinueSettings:
    """What a continue step does.

    Attributes
    ----------
    free, ranges
        Free parameters, and the lowest and highest value of each.
    step_initial, step_min, step_max, max_points
        Steps along the branch, and most points in each direction.
    ways
        Signs of the directions in which it is followed.
    follows_signatures
        Whether it goes on with another signature where its own ends.
    follows_halving
        Whether it goes on with the single orbit where both halves of its orbits become equal.
    switches
        Whether it starts on the other branch of a special point.
    signature
        Segments that the orbit must have (None: any).
    detect
        Labels of the special points that are looked for (None: all).
    user_functions
        Monitors whose zeros are located.
    multipliers
        Whether Floquet multipliers are computed, and how many.
    verifies
        Whether each orbit is simulated from its own past.
    """

    free: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    step_initial: float
    step_min: float
    step_max: float
    max_points: int
    ways: tuple[int, ...]
    follows_signatures: bool
    follows_halving: bool
    switches: bool
    signature: tuple[str, ...] | None
    detect: tuple[str, ...] | None
    user_functions: tuple[Monitor, ...]
    multipliers: MultiplierSettings
    verifies: bool


def resolve_continue(given: StepInput[Continue]) -> ContinueSettings:
    """Return what a continue step does; note what is wrong with it."""
    body = given.body
    _check_source(given)
    if len(set(body.free)) < len(body.free):
        twice = f"the parameter '{body.free[0]}' is listed twice; two different ones follow a special point"
        given.add_error(("free",), twice)
    if body.branch == "switch" and len(body.free) == 2 and given.source_holds == Holding.ORBIT:
        given.add_error(("branch",), "'switch' leads onto another branch in one free parameter; found two")
    signature = resolve_signature(given, ("signature",), body.signature)
    here = (*given.path, "events_along")
    check_new_names(given.checker, here, body.events_along, "user function", given.monitors)
    functions = resolve_monitors(given.checker, here, body.events_along, given.numeric, given.monitors)
    if body.detect:
        _check_detect(given)
    ranges = _resolve_ranges(given)
    return ContinueSettings(
        tuple(body.free),
        tuple(ranges.get(name, (0.0, 1.0)) for name in body.free),
        body.step.initial,
        body.step.min,
        body.step.max,
        body.max_points,
        WAYS[body.direction],
        body.signature_change == "follow",
        body.period_halving != "stop",
        body.branch == "switch",
        signature,
        None if body.detect is None else tuple(body.detect),
        tuple(functions.values()),
        resolve_multipliers(body.stability),
        body.verify is not False,
    )


def _check_source(given: StepInput[Continue]) -> None:
    """Check that the step starts from orbits."""
    if given.source is None:
        return
    name, holds = given.source.step, given.source_holds
    if holds == Holding.ATTRACTORS:
        between = f"{{name: orbit, orbit: {{from: {{step: {name}, point: A1}}}}}}"
        given.add_error(("from",), f"'{name}' holds attractors; put an orbit step between: {between}")
    if holds == Holding.TRAJECTORY:
        between = f"{{name: orbit, orbit: {{from: {name}}}}}"
        given.add_error(("from",), f"'{name}' is a trajectory; put an orbit step between: {between}")


def _check_detect(given: StepInput[Continue]) -> None:
    """Check that the kinds of special points asked for can be found in this step."""
    from pddecont.bifurcation import list_kinds
    from pddecont.equilibrium import CURVE_NAMES, NAMES

    on_curve = len(given.body.free) == 2
    kinds = {kind.label: kind for kind in list_kinds() if (kind.on_curves if on_curve else kind.on_branches)}
    # A branch above may be one of orbits or of equilibria, and from equilibria orbits are born.
    of_orbits = given.source_holds != Holding.EQUILIBRIA
    at_rest = () if given.source_holds == Holding.ORBIT else (CURVE_NAMES if on_curve else NAMES)
    known = dict.fromkeys([*(kinds if of_orbits else ()), *at_rest])
    where = "two free parameters" if on_curve else "one free parameter"
    for k, label in enumerate(given.body.detect or ()):
        if label not in known:
            given.add_error(("detect", k), f"'{label}' is not found with {where} (there are: {', '.join(known)})")
        elif label not in at_rest and kinds[label].needs_multipliers and not given.body.stability:
            given.add_error(("detect", k), f"'{label}' is seen from multipliers; add 'stability: true' to this step")


def _resolve_ranges(given: StepInput[Continue]) -> dict[str, tuple[float, float]]:
    body, ranges = given.body, {}
    for k, name in enumerate(body.free):
        if given.check_settable(("free", k), name, key=False) and name not in body.range:
            missing = f"the free parameter '{name}' has no range; add '{name}: [lowest, highest]'"
            given.add_error(("range",), missing)
    for name, limits in body.range.items():
        here = ("range", name)
        if name not in body.free:
            given.add_error(here, f"'{name}' has a range but is not free (free: {', '.join(body.free)})", key=True)
            continue
        low, high = (given.evaluate((*here, k), text) for k, text in enumerate(limits))
        if not low < high:
            given.add_error(here, f"the range is empty: {low:g} is not below {high:g}")
        ranges[name] = (low, high)
        start = given.known.get(name)
        if low < high and start is not None and not in_range(start, low, high):
            given.add_error(here, f"the step starts at {name} = {start:g}, outside this range; widen the range")
    return ranges


def in_range(value: float, low: float, high: float) -> bool:
    """Whether a parameter's value lies in its range, to rounding."""
    return low - EDGE * (high - low) <= value <= high + EDGE * (high - low)


def list_continue_names(body: Continue) -> Iterator[Any]:
    """Return the texts of a continue step whose names the model must have."""
    yield from body.events_along.values()


CONTINUE_STEP = StepKind(
    name="continue",
    fields=Continue,
    resolve=resolve_continue,
    format=CONTINUE,
    run="pddecont.steps.execution.continuation:run_continue",
    sharing=Sharing.EARLY,
    resumes=True,
    holds=Holding.BRANCH,
    takes_accuracy=True,
    list_names=list_continue_names,
    list_varied=lambda body: body.free,
)
