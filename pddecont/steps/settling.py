"""How motions are followed until they settle, and told from one another: what sweeps and basins have in common."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pddecont.codegen import NumericModel
from pddecont.model import Formula, Identifier, Strict
from pddecont.runfile import ParameterFormula, StepInput
from pddecont.simulate import Method, ReturnSection, ReturnSettings
from pddecont.steps.fields import Grid
from pddecont.steps.motion import Integration, resolve_method

Array = NDArray[np.float64]


class Section(Strict):
    """Where returns are counted; without it once a forcing period, from phase 0."""

    phase: float | None = Field(
        None, ge=0, lt=1, description="part of the forcing period that has passed at each return"
    )
    event: Identifier | None = Field(None, description="an event of the model; the state after it is the return")
    zero: Formula | None = Field(None, description="an expression whose zeros are the returns")
    direction: Literal["rising", "falling", "any"] = Field("rising", description="direction in which 'zero' is crossed")

    @model_validator(mode="after")
    def _check_one(self) -> Section:
        if sum(x is not None for x in (self.phase, self.event, self.zero)) != 1:
            raise PydanticCustomError("section", "expected exactly one of phase, event, zero", {})
        return self


class Settling(Integration):
    """How a motion is followed until it has settled, and told from others."""

    rtol: float = Field(1e-8, gt=0, lt=1, description="relative error allowed in a step")
    atol: float = Field(1e-10, gt=0, description="absolute error allowed in a step")
    transient: Formula = Field(description="longest time that a motion is given to settle")
    section: Section | None = Field(None, description="where returns are counted")
    max_period: int = Field(16, ge=1, le=256, description="longest period, in returns, that is told from no period")
    returns: int = Field(64, ge=2, le=100_000, description="returns kept of a motion without period")
    lyapunov: bool = Field(False, description="the largest Lyapunov exponent of each attractor")


@dataclass(frozen=True, eq=False)
class SettlingSettings:
    """How motions are computed and where their returns are counted.

    ``phase`` is the part of the forcing period that has passed at each return (None: returns are counted at
    ``section``), ``shown_section`` the section as files keep it.
    """

    method: Method
    section: ReturnSection
    phase: float | None
    transient: ParameterFormula
    max_period: int
    n_returns: int
    lyapunov: bool
    shown_section: Mapping[str, Any]

    def make_return_settings(self, numeric: NumericModel, p: Array) -> ReturnSettings:
        """Return when returns come at parameters ``p``."""
        forced = self.phase is not None and numeric.model.forced
        period = float(numeric.period.value(p)[0]) if forced else 0.0
        transient = self.transient.evaluate(dict(zip(numeric.model.parameters, p.tolist(), strict=True)))
        return ReturnSettings(period, self.phase or 0.0, transient, self.max_period, self.n_returns)


def resolve_settling(given: StepInput[Any], body: Settling) -> SettlingSettings:
    """Return how motions of a step settle; note what is wrong with it."""
    method = resolve_method(given, body)
    transient = given.parse_formula(("transient",), body.transient)
    longest = given.checker.evaluate_formula((*given.path, "transient"), transient, given.values)
    if longest <= 0:
        given.add_error(("transient",), f"transient is {longest:g}; expected a positive time")
    if body.lyapunov and body.stick:
        given.add_error(
            ("lyapunov",),
            "what neighbouring motions do where events accumulate is not followed: Lyapunov exponents "
            "do not go with 'stick'",
        )
    if body.lyapunov and body.method == "stiff":
        given.add_error(("lyapunov",), "Lyapunov exponents go with the explicit method; leave 'method: stiff' out")
    section = body.section or Section.model_validate({"phase": 0.0})
    return SettlingSettings(
        method,
        resolve_section(given, section, is_default=body.section is None),
        section.phase,
        transient,
        body.max_period,
        body.returns,
        body.lyapunov,
        section.model_dump(exclude_none=True),
    )


def resolve_section(given: StepInput[Any], section: Section, *, is_default: bool) -> ReturnSection:
    """Return where returns are counted; note what is wrong with it, or with the ``is_default`` that a step leaves."""
    model = given.model
    if section.phase is not None:
        if not model.forced:
            event = next(iter(model.events), None)
            example = f"{{event: {event}}}" if event else f"{{zero: {model.states[0]} - 1}}"
            why = model.left_out.hint("forcing", "period")
            given.add_error(
                () if is_default else ("section",),
                f"the model has no forcing whose periods could count returns{why}; say where they are counted: "
                f"'section: {example}'",
                key=is_default,
            )
        return ReturnSection()
    if section.event is not None:
        if section.event not in model.events:
            hint = model.hint("events", section.event, model.events)
            known = f"(events: {', '.join(model.events) or 'none'})"
            given.add_error(("section", "event"), f"'{section.event}' is not an event{hint} {known}")
        return ReturnSection(event=section.event)
    expr = given.parse(("section", "zero"), section.zero or 0.0, model.scope("a section"))
    return ReturnSection(expr=expr, direction=section.direction)


def resolve_grid(given: StepInput[Any], over: Mapping[str, Grid]) -> dict[str, Array]:
    """Return the values of each name that varies; note empty ranges."""
    grids = {}
    for name, (low, high, n) in over.items():
        ends = [given.evaluate(("over", name, k), text) for k, text in enumerate((low, high))]
        if ends[0] > ends[1] or (ends[0] == ends[1] and n != 1):
            given.add_error(("over", name), f"the range is empty: {ends[0]:g} is not below {ends[1]:g}")
        grids[name] = np.linspace(ends[0], ends[1], int(n))
    return grids


def list_section_names(body: Settling) -> Iterator[str | float]:
    """Return the text of the section."""
    if body.section is not None and body.section.zero is not None:
        yield body.section.zero
