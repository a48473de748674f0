"""The ``precision`` step: what accuracy costs, by many settings for one orbit or one simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Annotated, Any, Literal

import sympy
from pydantic import Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from pddecont.collocation import MeshRule
from pddecont.errors import suggest
from pddecont.model import Formula, Identifier, Strict
from pddecont.orbit import Monitor
from pddecont.results import PRECISION
from pddecont.runfile import (
    DEFAULT_ORDER,
    DEFAULT_POINTS,
    DEFAULT_STEPS,
    Delay,
    From,
    Holding,
    StepInput,
    resolve_monitors,
)
from pddecont.steps.fields import Several
from pddecont.steps.kind import Sharing, StepKind

OF_ORBITS, OF_RUNS = ("methods", "degrees", "intervals"), ("integrators",)
INTERVALS = (8, 16, 32)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)


class Compared(Strict):
    """Ways to find delayed values that are compared; lists stand for one way each."""

    method: Literal["direct", "chain", "chebyshev"] = Field(description="as in 'delay'")
    track_breaking_points: bool | None = Field(None, description="direct: as in 'delay'")
    order: Several | None = Field(None, description="chain: orders M of each Taylor step")
    n: Several | None = Field(None, description="chain: numbers of Taylor steps; chebyshev: numbers of points")
    states: Literal["eliminated", "explicit"] | None = Field(
        None,
        description=(
            "chain: stages eliminated from the unknowns (the default), or each a state of its own as in the paper"
        ),
    )

    @model_validator(mode="after")
    def _check_delays(self) -> Compared:
        if self.states is not None and self.method != "chain":
            raise PydanticCustomError("delay", "'states' does not go with method '{method}'", {"method": self.method})
        self.make_delays()
        return self

    def make_delays(self) -> list[Delay]:
        """Return one way each."""
        given = {"method": self.method, "track_breaking_points": self.track_breaking_points}
        orders: list[int | None] = [*self.order] if self.order else [None]
        numbers: list[int | None] = [*self.n] if self.n else [None]
        try:
            return [Delay.model_validate({**given, "order": order, "n": n}) for order in orders for n in numbers]
        except ValidationError as exc:
            raise PydanticCustomError("delay", "{what}", {"what": exc.errors()[0]["msg"]}) from exc


class Precision(Strict):
    """What accuracy costs: quantities of one orbit, or of one simulation's end, by many settings."""

    from_: From = Field(alias="from", description="an orbit step, a point of a branch, or a simulate step")
    quantities: dict[Identifier, Formula] = Field(
        min_length=1, description="monitors of the orbit, or expressions in the last state"
    )
    reference: dict[Identifier, Formula] = Field(
        default_factory=dict,
        description=(
            "values of the quantities in closed form; those not given come from the finest solution, checked on two "
            "meshes"
        ),
    )
    methods: list[Compared] = Field(
        default_factory=lambda: [Compared.model_validate({"method": "direct"})],
        min_length=1,
        description=("orbits: ways to find delayed values"),
    )
    degrees: Several = Field(default_factory=lambda: [4, 6, 8], description="orbits: degrees of the polynomials")
    intervals: Several | None = Field(None, description="orbits: numbers of mesh intervals a period")
    tolerances: list[Annotated[float, Field(gt=0, lt=1)]] | None = Field(
        None,
        min_length=1,
        description=("orbits: mesh tolerances, instead of intervals; simulations: relative tolerances"),
    )
    integrators: list[Literal["explicit", "stiff"]] | None = Field(
        None, min_length=1, description="simulations: methods (default both)"
    )
    repeats: int = Field(3, ge=1, le=1000, description="how often each is timed; the median counts")

    @model_validator(mode="after")
    def _check_rule(self) -> Precision:
        if self.intervals is not None and self.tolerances is not None:
            raise PydanticCustomError("mesh", "'tolerances' and 'intervals' exclude each other", {})
        return self


@dataclass(frozen=True)
class OrbitSetting:
    """A way to find delayed values, ``explicit`` where a chain's stages are states of their own, and a mesh rule."""

    delay: Delay
    explicit: bool
    rule: MeshRule

    @property
    def order(self) -> int:
        """Order of a chain's Taylor steps (0: it is none)."""
        return self.delay.order or DEFAULT_ORDER if self.delay.method == "chain" else 0

    @property
    def n(self) -> int:
        """Number of Taylor steps or Chebyshev points (0: the method has none)."""
        default = {"direct": 0, "chain": DEFAULT_STEPS, "chebyshev": DEFAULT_POINTS}[self.delay.method]
        return self.delay.n or default


@dataclass(frozen=True)
class IntegratorSetting:
    """An integrator and its relative tolerance."""

    integrator: str
    tolerance: float


@dataclass(frozen=True, eq=False)
class OrbitComparison:
    """What a precision step compares of an orbit: quantities, closed forms of some (others NaN), settings.

    ``texts`` are the quantities as they are written, as models with more states need them read anew.
    """

    quantities: tuple[Monitor, ...]
    texts: Mapping[str, str | float]
    reference: tuple[float, ...]
    settings: tuple[OrbitSetting, ...]
    repeats: int

    @property
    def names(self) -> list[str]:
        """Names of the quantities."""
        return [monitor.name for monitor in self.quantities]


@dataclass(frozen=True, eq=False)
class IntegrationComparison:
    """What a precision step compares of the end of a simulate step: the same."""

    quantities: Mapping[str, sympy.Expr]
    reference: tuple[float, ...]
    settings: tuple[IntegratorSetting, ...]
    repeats: int

    @property
    def names(self) -> list[str]:
        """Names of the quantities."""
        return list(self.quantities)


def resolve_precision(given: StepInput[Precision]) -> OrbitComparison | IntegrationComparison:
    """Return what a precision step compares; note what is wrong with it."""
    body = given.body
    if given.source_holds == Holding.ATTRACTORS:
        what = f"is a {given.source_kind} step; what is compared is an orbit or a simulation"
        given.add_error(("from",), f"'{body.from_.step}' {what}")
    integrated = given.source_holds == Holding.TRAJECTORY
    for key in OF_ORBITS if integrated else OF_RUNS:
        if key in body.model_fields_set:
            compared = "simulations" if integrated else "orbits"
            given.add_error((key,), f"'{key}' does not go with {compared}", key=True)
    if integrated and given.has_own_parameters:
        own = "a comparison of simulations has the parameters of its simulate step; leave 'set' out"
        given.add_error((), own, key=True)
    reference = tuple(_resolve_reference(given).values())
    if integrated:
        scope = given.model.scope("a quantity", delayed=given.model.delayed_value)
        quantities = {name: given.parse(("quantities", name), text, scope) for name, text in body.quantities.items()}
        runs = product(body.integrators or ("explicit", "stiff"), body.tolerances or TOLERANCES)
        settings = tuple(IntegratorSetting(*pair) for pair in runs)
        return IntegrationComparison(quantities, reference, settings, body.repeats)
    monitors = tuple(
        resolve_monitors(given.checker, (*given.path, "quantities"), body.quantities, given.numeric).values()
    )
    return OrbitComparison(monitors, body.quantities, reference, _list_orbit_settings(body), body.repeats)


def _resolve_reference(given: StepInput[Precision]) -> dict[str, float]:
    """Return closed forms of the quantities; NaN where none is given."""
    quantities = given.body.quantities
    values = dict.fromkeys(quantities, float("nan"))
    for name, text in given.body.reference.items():
        here = ("reference", name)
        if name not in quantities:
            known = f"{suggest(name, quantities)} (quantities: {', '.join(quantities)})"
            given.add_error(here, f"'{name}' is not among the quantities{known}", key=True)
        values[name] = given.evaluate(here, text)
    return values


def _list_orbit_settings(body: Precision) -> tuple[OrbitSetting, ...]:
    delays = [(delay, compared.states == "explicit") for compared in body.methods for delay in compared.make_delays()]
    if body.tolerances is not None:
        rules = [MeshRule(degree, None, tol) for degree, tol in product(body.degrees, body.tolerances)]
    else:
        rules = [MeshRule(degree, n) for degree, n in product(body.degrees, body.intervals or INTERVALS)]
    return tuple(OrbitSetting(delay, explicit, rule) for (delay, explicit), rule in product(delays, rules))


def list_precision_names(body: Precision) -> Iterator[Any]:
    """Return the texts of a precision step whose names the model must have."""
    yield from body.quantities.values()


PRECISION_STEP = StepKind(
    name="precision",
    fields=Precision,
    resolve=resolve_precision,
    format=PRECISION,
    run="pddecont.steps.execution.precision:run_precision",
    sharing=Sharing.ALONE,
    resumes=True,
    list_names=list_precision_names,
)
