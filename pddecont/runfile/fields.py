"""What any run file may say, whatever its steps: effects, delay, mesh, where a step starts."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from pddecont.collocation import MAX_DEGREE, MeshRule
from pddecont.delay import Chain, Chebyshev, DelayMethod, Direct
from pddecont.model import UNION_TAG, Identifier, SegmentName, Strict

# What a file need not say.
DEFAULT_TOLERANCE = 1e-8
DEFAULT_ORDER, DEFAULT_STEPS, DEFAULT_POINTS = 2, 15, 16


class Effects(Strict):
    """Which effects of the model the run leaves out."""

    off: list[Identifier] = Field(default_factory=list, description="effects to leave out")


class Delay(Strict):
    """How delayed values are found."""

    method: Literal["direct", "chain", "chebyshev"] = Field(
        "direct",
        description=(
            "direct: read from the orbit itself; chain: Taylor steps of the paper's section 2.2; chebyshev: "
            "pseudospectral delay line"
        ),
    )
    track_breaking_points: bool | None = Field(
        None, description="direct: let the mesh follow the breaking points (default true)"
    )
    order: int | None = Field(None, ge=1, le=20, description="chain: order M of each Taylor step (default 2)")
    n: int | None = Field(
        None, ge=1, le=1_000_000, description="chain: number of Taylor steps (15); chebyshev: number of points (16)"
    )

    @model_validator(mode="after")
    def _fits_the_method(self) -> Delay:
        own = {"direct": {"track_breaking_points"}, "chain": {"order", "n"}, "chebyshev": {"n"}}[self.method]
        for key in ("track_breaking_points", "order", "n"):
            if getattr(self, key) is not None and key not in own:
                raise PydanticCustomError(
                    "delay", "'{key}' does not go with method '{method}'", {"key": key, "method": self.method}
                )
        if self.method == "chebyshev" and (self.n or 0) > 60:
            raise PydanticCustomError("delay", "a Chebyshev delay line has at most 60 points, found {n}", {"n": self.n})
        return self

    def make_method(self) -> DelayMethod:
        """Return the delay method that is meant."""
        if self.method == "chain":
            return Chain(self.order or DEFAULT_ORDER, self.n or DEFAULT_STEPS)
        if self.method == "chebyshev":
            return Chebyshev(self.n or DEFAULT_POINTS)
        return Direct(self.track_breaking_points is not False)


class Mesh(Strict):
    """Mesh of piecewise polynomials."""

    degree: int = Field(6, ge=1, le=MAX_DEGREE, description="degree of the polynomials")
    tol: float | None = Field(None, gt=0, lt=1, description="error allowed relative to the orbit's size (default 1e-8)")
    intervals: int | None = Field(
        None, ge=1, le=100_000, description="fixed number of mesh intervals a period, instead of tol"
    )

    @model_validator(mode="after")
    def _one_rule(self) -> Mesh:
        if self.tol is not None and self.intervals is not None:
            raise PydanticCustomError("mesh", "'tol' and 'intervals' exclude each other", {})
        return self

    def make_rule(self) -> MeshRule:
        """Return the mesh rule that is meant."""
        return MeshRule(self.degree, self.intervals, None if self.intervals else self.tol or DEFAULT_TOLERANCE)


class Source(Strict):
    """Where a step starts: an earlier step, or one of its points."""

    file: str | None = Field(None, description="another results file, relative to the run file")
    step: Identifier = Field(description="step to start from")
    point: str | None = Field(None, description="label of the point, such as GR1")
    index: int | None = Field(None, ge=0, description="row of the point, instead of a label")


def _as_source(value: Any) -> Any:
    return Source.model_validate({"step": value}) if isinstance(value, str) else value


From = Annotated[Source, BeforeValidator(_as_source)]


class TrajectoryFile(Strict):
    """A file that holds one period of a motion, as a first guess of an orbit."""

    trajectory: str = Field(
        description=(
            "CSV file, relative to the run file: columns t (or time), each state by name and, if wanted, segment; the "
            "last row closes the period"
        )
    )
    signature: list[SegmentName] | None = Field(
        None, min_length=1, description="segments in order (default: what the column 'segment' names)"
    )
    mode: Identifier | None = Field(
        None, description="mode of an orbit that meets no event, in a model that has events"
    )

    @model_validator(mode="after")
    def _check_one(self) -> TrajectoryFile:
        if self.signature is not None and self.mode is not None:
            raise PydanticCustomError("mode", "'mode' is for an orbit that meets no event; leave 'signature' out", {})
        return self


_STEP, _TRAJECTORY = f"{UNION_TAG}step", f"{UNION_TAG}trajectory"


def _find_form(value: Any) -> str:
    is_file = isinstance(value, TrajectoryFile) or (isinstance(value, dict) and "trajectory" in value)
    return _TRAJECTORY if is_file else _STEP


FromOrTrajectory = Annotated[
    Annotated[From, Tag(_STEP)] | Annotated[TrajectoryFile, Tag(_TRAJECTORY)], Discriminator(_find_form)
]
