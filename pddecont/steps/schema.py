"""The shape of a run file (design section 3): which keys, which kinds of values."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, ValidationError, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from pddecont.model.validation import Formula, Identifier, Strict


class Effects(Strict):
    """Which effects of the model the run leaves out."""

    off: list[Identifier] = Field(default_factory=list, description="effects to leave out")


class Delay(Strict):
    """How delayed values are found."""

    method: Literal["direct", "chain", "chebyshev"] = Field("direct", description=(
        "direct: read from the orbit itself; chain: Taylor steps of the paper's section 2.2; chebyshev: pseudospectral delay line"))
    track_breaking_points: bool | None = Field(None, description="direct: let the mesh follow the breaking points (default true)")
    order: int | None = Field(None, ge=1, le=20, description="chain: order M of each Taylor step (default 2)")
    n: int | None = Field(None, ge=1, le=1_000_000, description="chain: number of Taylor steps (15); chebyshev: number of points (16)")

    @model_validator(mode="after")
    def _fits_the_method(self) -> Delay:
        own = {"direct": {"track_breaking_points"}, "chain": {"order", "n"}, "chebyshev": {"n"}}[self.method]
        for key in ("track_breaking_points", "order", "n"):
            if getattr(self, key) is not None and key not in own:
                raise PydanticCustomError("delay", "'{key}' does not go with method '{method}'", {"key": key, "method": self.method})
        if self.method == "chebyshev" and (self.n or 0) > 60:
            raise PydanticCustomError("delay", "a Chebyshev delay line has at most 60 points, found {n}", {"n": self.n})
        return self


class Mesh(Strict):
    """Mesh of piecewise polynomials."""

    degree: int = Field(6, ge=1, le=20, description="degree of the polynomials")
    tol: float | None = Field(None, gt=0, lt=1, description="error allowed relative to the orbit's size (default 1e-8)")
    intervals: int | None = Field(None, ge=1, le=100_000, description="fixed number of mesh intervals a period, instead of tol")

    @model_validator(mode="after")
    def _one_rule(self) -> Mesh:
        if self.tol is not None and self.intervals is not None:
            raise PydanticCustomError("mesh", "'tol' and 'intervals' exclude each other", {})
        return self


class Source(Strict):
    """Where a step starts: an earlier step, or one of its points."""

    file: str | None = Field(None, description="another results file, relative to the run file")
    step: Identifier = Field(description="step to start from")
    point: str | None = Field(None, description="label of the point, such as GR1")
    index: int | None = Field(None, ge=0, description="row of the point, instead of a label")


def _source(value: Any) -> Any:
    return Source.model_validate({"step": value}) if isinstance(value, str) else value


From = Annotated[Source, BeforeValidator(_source)]


class Integration(Strict):
    """How trajectories are computed."""

    rtol: float = Field(1e-9, gt=0, lt=1, description="relative error allowed in a step")
    atol: float = Field(1e-11, gt=0, description="absolute error allowed in a step")
    method: Literal["explicit", "stiff"] = Field("explicit", description="explicit: DOP853; stiff: Radau IIA of order 5")
    max_step: Formula | None = Field(None, description="longest step, where an event function has features that longer ones would miss")
    stick: dict[Identifier, Identifier] = Field(default_factory=dict, description="mode to go on in where an event accumulates, by event")


def _history(value: Any) -> Any:
    words = ("model", "constant")
    if isinstance(value, dict) or value in words:
        return value
    raise PydanticCustomError("history", "expected model, constant, or a mapping of states to expressions in t; found {value}",
                              {"value": repr(value)})  # fmt: skip


History = Annotated[Any, BeforeValidator(_history), WithJsonSchema({"anyOf": [
    {"enum": ["model", "constant"]}, {"type": "object", "additionalProperties": {"anyOf": [{"type": "number"}, {"type": "string"}]}}]})]


class Initial(Strict):
    """Where a trajectory starts: any states by name, the mode, the history before."""

    model_config = ConfigDict(extra="allow")
    mode: Identifier | None = Field(None, description="mode at the start")
    history: History = Field("model", description="before the start: the model's, constant (the initial states), or expressions in t")

    @property
    def states(self) -> dict[str, str | float]:
        """The states that are given, by name."""
        return dict(self.model_extra or {})

    @model_validator(mode="after")
    def _numbers(self) -> Initial:
        for name, value in self.states.items():
            if isinstance(value, bool) or not isinstance(value, (str, int, float)):
                raise PydanticCustomError("state", "'{name}' takes a number or an expression", {"name": name})
        return self


class Record(Strict):
    """What is kept of a trajectory."""

    from_: Formula = Field(0.0, alias="from", description="time from which on it is kept")
    every: Formula | None = Field(None, description="time between the samples that are written (default: four a step)")
    signals: dict[Identifier, Formula] = Field(default_factory=dict, description="expressions recorded along it, delayed values too")


class Simulate(Integration):
    """Integrate from an initial state or history."""

    t_end: Formula = Field(description="time at which to stop")
    initial: Initial = Field(default_factory=lambda: Initial.model_validate({}))
    at: dict[str, dict[Identifier, Formula]] = Field(default_factory=dict, description="parameters that change, by time")
    record: Record = Field(default_factory=lambda: Record.model_validate({}))


def _grid(value: Any) -> Any:
    if not isinstance(value, list) or len(value) != 3:
        raise PydanticCustomError("grid", "expected a list of three: [lowest, highest, how many]", {})
    n = value[2]
    if isinstance(n, bool) or not isinstance(n, int | float) or n != int(n) or not 1 <= n <= 100_000:
        raise PydanticCustomError("grid", "the third, how many values there are, is a whole number from 1 to 100000", {})
    return value


Grid = Annotated[list[Formula], BeforeValidator(_grid)]


class Section(Strict):
    """Where returns are counted; without it once a forcing period, from phase 0."""

    phase: float | None = Field(None, ge=0, lt=1, description="part of the forcing period that has passed at each return")
    event: Identifier | None = Field(None, description="an event of the model; the state after it is the return")
    zero: Formula | None = Field(None, description="an expression whose zeros are the returns")
    direction: Literal["rising", "falling", "any"] = Field("rising", description="direction in which 'zero' is crossed")

    @model_validator(mode="after")
    def _one(self) -> Section:
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


class Scatter(Strict):
    """Initial states at random."""

    number: int = Field(ge=1, le=100_000, description="how many")
    seed: int = Field(1, ge=0, description="start of the random numbers")
    box: dict[Identifier, Annotated[list[Formula], BeforeValidator(lambda v: _range(v))]] = Field(
        min_length=1, description="lowest and highest value of each state that varies")


class Sweep(Settling):
    """Where motions settle over a grid of one or two parameters."""

    over: dict[Identifier, Grid] = Field(min_length=1, max_length=2, description="parameters: lowest, highest, how many values")
    initial: list[Initial] = Field(default_factory=lambda: [Initial.model_validate({})], min_length=1, description=(
        "initial states; each is tried at every parameter"))
    random: Scatter | None = Field(None, description="more initial states, at random")
    carry: Literal["none", "up", "down", "both"] = Field("none", description=(
        "go on from where the motion stood at the parameter before, upwards, downwards or both; the first parameter is carried along"))


class Basin(Settling):
    """Which attractor each of a grid of initial states leads to."""

    over: dict[Identifier, Grid] = Field(min_length=2, max_length=2, description="two states: lowest, highest, how many values")
    initial: Initial = Field(default_factory=lambda: Initial.model_validate({"history": "constant"}), description=(
        "the other states, the mode and the history (constant unless given)"))


class Stability(Strict):
    """How many Floquet multipliers are computed."""

    multipliers: int = Field(ge=1, le=200, description="number of leading multipliers")


def _stability(value: Any) -> Any:
    if not isinstance(value, (bool, dict, Stability)):
        raise PydanticCustomError("stability", "expected true, false, or {some}; found {value}",
                                  {"some": "{multipliers: N}", "value": repr(value)})  # fmt: skip
    return value


StabilityChoice = Annotated[bool | Stability, BeforeValidator(_stability), Field(description=(
    "Floquet multipliers: true for those of modulus above 1e-3 (at most 12), or {multipliers: N} for the N leading ones"))]


class Orbit(Strict):
    """Find the periodic orbit that a trajectory has settled to, or solve a recorded orbit anew."""

    from_: From = Field(alias="from", description="a simulate step, an attractor of a sweep or basin, or an orbit")
    signature: list[Identifier] | None = Field(None, description="segments that the orbit must have")
    stability: StabilityChoice = False


class StepSize(Strict):
    """Lengths of steps along a branch; a parameter's range counts as one, and so does the orbit's size."""

    initial: float = Field(0.02, gt=0, description="first step")
    min: float = Field(1e-6, gt=0, description="smallest step before the branch is given up")
    max: float = Field(0.1, gt=0, description="largest step")

    @model_validator(mode="after")
    def _in_order(self) -> StepSize:
        if not self.min <= self.initial <= self.max:
            raise PydanticCustomError("order", "expected min <= initial <= max", {})
        return self


def _range(value: Any) -> Any:
    if not isinstance(value, list) or len(value) != 2:
        raise PydanticCustomError("range", "expected a list of two numbers: [lowest, highest]", {})
    return value


OnBranch = Literal["LP", "BP", "PD", "TR", "GR", "VS", "UF"]
OnCurve = Literal["CP", "R1", "R2", "R3", "R4", "FF", "FT", "PT", "TT", "GG", "GL", "GP", "GT", "VS", "UF"]


class Continue(Strict):
    """Follow an orbit in one free parameter, or a special point in two."""

    from_: From = Field(alias="from", description="an orbit or a special point")
    free: list[Identifier] = Field(min_length=1, max_length=2, description="parameter to vary; two to follow a special point")
    range: dict[Identifier, Annotated[list[Formula], BeforeValidator(_range)]] = Field(description="lowest and highest value")
    step: StepSize = Field(default_factory=lambda: StepSize.model_validate({}))
    max_points: int = Field(500, ge=1, le=1_000_000, description="most points in each direction")
    direction: Literal["both", "up", "down"] = Field("both", description="which way the parameter goes at first")
    stability: StabilityChoice = False
    signature_change: Literal["follow", "stop"] = Field("follow", description="what to do where an orbit grazes or a segment vanishes")
    branch: Literal["same", "switch"] = Field("same", description="switch: onto the other branch at a PD or BP point")
    signature: list[Identifier] | None = Field(None, min_length=1, description=(
        "segments that the orbit must have; at a GR point those after it"))
    detect: list[Literal[OnBranch, OnCurve]] | None = Field(None, description=(
        "kinds of special points that are looked for, such as [GR, LP] (default: all that there can be; []: none)"))
    events_along: dict[Identifier, Formula] = Field(default_factory=dict, description="user functions whose zeros are located")


Several = Annotated[list[Annotated[int, Field(ge=1)]], BeforeValidator(lambda v: v if isinstance(v, list) else [v]), Field(min_length=1)]


class Compared(Strict):
    """Ways to find delayed values that are compared; lists stand for one way each."""

    method: Literal["direct", "chain", "chebyshev"] = Field(description="as in 'delay'")
    track_breaking_points: bool | None = Field(None, description="direct: as in 'delay'")
    order: Several | None = Field(None, description="chain: orders M of each Taylor step")
    n: Several | None = Field(None, description="chain: numbers of Taylor steps; chebyshev: numbers of points")
    states: Literal["eliminated", "explicit"] | None = Field(None, description=(
        "chain: stages eliminated from the unknowns (the default), or each a state of its own as in the paper"))

    @model_validator(mode="after")
    def _are_delays(self) -> Compared:
        if self.states is not None and self.method != "chain":
            raise PydanticCustomError("delay", "'states' does not go with method '{method}'", {"method": self.method})
        self.delays()
        return self

    def delays(self) -> list[Delay]:
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
    quantities: dict[Identifier, Formula] = Field(min_length=1, description="monitors of the orbit, or expressions in the last state")
    reference: dict[Identifier, Formula] = Field(default_factory=dict, description=(
        "values of the quantities in closed form; those not given come from the finest solution, checked on two meshes"))
    methods: list[Compared] = Field(default_factory=lambda: [Compared.model_validate({"method": "direct"})], min_length=1, description=(
        "orbits: ways to find delayed values"))
    degrees: Several = Field(default_factory=lambda: [4, 6, 8], description="orbits: degrees of the polynomials")
    intervals: Several | None = Field(None, description="orbits: numbers of mesh intervals a period")
    tolerances: list[Annotated[float, Field(gt=0, lt=1)]] | None = Field(None, min_length=1, description=(
        "orbits: mesh tolerances, instead of intervals; simulations: relative tolerances"))
    integrators: list[Literal["explicit", "stiff"]] | None = Field(None, min_length=1, description="simulations: methods (default both)")
    repeats: int = Field(3, ge=1, le=1000, description="how often each is timed; the median counts")

    @model_validator(mode="after")
    def _one_rule(self) -> Precision:
        if self.intervals is not None and self.tolerances is not None:
            raise PydanticCustomError("mesh", "'tolerances' and 'intervals' exclude each other", {})
        return self


class Step(Strict):
    """One step of a run; exactly one of its kinds."""

    name: Identifier = Field(description="name of the step in the results")
    set: dict[Identifier, Formula] = Field(default_factory=dict, description="parameter values for this step")
    delay: Delay | None = None
    mesh: Mesh | None = None
    simulate: Simulate | None = None
    sweep: Sweep | None = None
    basin: Basin | None = None
    orbit: Orbit | None = None
    continue_: Continue | None = Field(None, alias="continue")
    precision: Precision | None = None

    @property
    def kind(self) -> str:
        """Which kind of step this is."""
        return next(k for k in KINDS if self.body_of(k) is not None)

    @property
    def source(self) -> Source | None:
        """Where the step starts."""
        return getattr(self.body_of(self.kind), "from_", None)

    def body_of(self, kind: str) -> Any:
        """Return what the file says under ``kind``."""
        return getattr(self, "continue_" if kind == "continue" else kind)

    @model_validator(mode="after")
    def _one_kind(self) -> Step:
        given = [k for k in KINDS if self.body_of(k) is not None]
        if len(given) != 1:
            raise PydanticCustomError("kind", "a step has exactly one of {kinds}; found {given}",
                                      {"kinds": ", ".join(KINDS), "given": ", ".join(given) or "none"})  # fmt: skip
        return self


KINDS = ("simulate", "sweep", "basin", "orbit", "continue", "precision")


class RunBlock(Strict):
    """A run without its model: what stands under ``run`` in a model file."""

    set: dict[Identifier, Formula] = Field(default_factory=dict, description="parameter values")
    effects: Effects = Field(default_factory=lambda: Effects.model_validate({}))
    accuracy: float | None = Field(None, ge=1e-11, lt=1, description=(
        "error allowed on orbits, relative to their sizes; method, degree and mesh are chosen for it, instead of 'delay' and 'mesh'"))
    delay: Delay = Field(default_factory=lambda: Delay.model_validate({}))
    mesh: Mesh = Field(default_factory=lambda: Mesh.model_validate({}))
    monitors: dict[Identifier, Formula] = Field(default_factory=dict, description="numbers recorded at every point")
    steps: list[Step] = Field(min_length=1, description="what to do, in order")

    @model_validator(mode="after")
    def _one_rule(self) -> RunBlock:
        for key in ("delay", "mesh"):
            if self.accuracy is not None and key in self.model_fields_set:
                raise PydanticCustomError("accuracy", "'accuracy' chooses the method and the mesh; leave '{key}' out, or give it to a step",
                                          {"key": key})  # fmt: skip
        return self


class RunFile(RunBlock):
    """A run file (design section 3)."""

    model: str = Field(description="model file, relative to this file, or the name of a shipped model")
