"""The ``orbit`` step: the periodic orbit that a trajectory has settled to, a recorded or a given one solved anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import Field

from pddecont.errors import RunError, SignatureError
from pddecont.model import SegmentName, Strict, check_signature
from pddecont.orbit import SampledCycle, find_cycle, read_motion_table
from pddecont.results import ORBIT
from pddecont.runfile import FromOrTrajectory, Holding, Path, Source, StepInput, TrajectoryFile
from pddecont.steps.fields import Stability, StabilityChoice, Verify
from pddecont.steps.kind import Sharing, StepKind


class Orbit(Strict):
    """Find the periodic orbit that a trajectory has settled to, near one in a file, or solve a recorded one anew."""

    start: FromOrTrajectory = Field(
        alias="from",
        description="a simulate step, an attractor of a sweep or basin, an orbit, or a file with one period of one",
    )
    signature: list[SegmentName] | None = Field(None, description="segments that the orbit must have")
    stability: StabilityChoice = False
    verify: Verify = None

    @property
    def from_(self) -> Source | None:
        """The step that it starts from, if it does."""
        return self.start if isinstance(self.start, Source) else None


@dataclass(frozen=True)
class MultiplierSettings:
    """Whether Floquet multipliers are computed, and how many (None: those that are not small)."""

    wanted: bool = False
    number: int | None = None


@dataclass(frozen=True, eq=False)
class OrbitSettings:
    """What an orbit step does.

    ``signature`` is what the orbit must have (None: any); ``verifies`` whether it is simulated from its own past;
    ``cycle`` is the motion of a file that it starts from (None: it starts from a step).
    """

    signature: tuple[str, ...] | None
    multipliers: MultiplierSettings
    verifies: bool
    cycle: SampledCycle | None = None


def resolve_orbit(given: StepInput[Orbit]) -> OrbitSettings:
    """Return what an orbit step does; note what is wrong with it."""
    signature = resolve_signature(given, ("signature",), given.body.signature)
    start, cycle = given.body.start, None
    if isinstance(start, TrajectoryFile):
        cycle = _read_cycle(given, start)
    return OrbitSettings(signature, resolve_multipliers(given.body.stability), given.body.verify is not False, cycle)


def _read_cycle(given: StepInput[Orbit], start: TrajectoryFile) -> SampledCycle | None:
    """Return the cycle that a file holds; None, and a problem noted, if it holds none."""
    place, model = ("from", "trajectory"), given.model
    signature = resolve_signature(given, ("from", "signature"), start.signature) or given.body.signature or ()
    if start.mode is not None and start.mode not in model.modes:
        hint = f"{model.hint('modes', start.mode, model.modes)} (modes: {', '.join(model.modes)})"
        given.add_error(("from", "mode"), f"mode '{start.mode}' is not defined{hint}")
    text = given.read_file(place, start.trajectory)
    if text is None:
        return None
    path = str(given.folder / start.trajectory)
    try:
        table = read_motion_table(text, path, model)
        if given.checker.errors:
            return None
        return find_cycle(given.numeric, given.parameters, table, signature, start.mode)
    except RunError as exc:
        given.add_error(place, str(exc))
    except SignatureError as exc:
        given.add_error(place, f"{path}: {exc}")
    return None


def resolve_signature(given: StepInput[Any], path: Path, signature: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return a signature; note if no motion can run through it."""
    if signature is None:
        return None
    try:
        check_signature(given.model, list(signature))
    except SignatureError as exc:
        given.add_error(path, str(exc))
    return tuple(signature)


def resolve_multipliers(choice: bool | Stability) -> MultiplierSettings:
    """Return which multipliers are wanted."""
    return MultiplierSettings(True, choice.multipliers) if isinstance(choice, Stability) else MultiplierSettings(choice)


ORBIT_STEP = StepKind(
    name="orbit",
    fields=Orbit,
    resolve=resolve_orbit,
    format=ORBIT,
    run="pddecont.steps.execution.orbit:run_orbit",
    sharing=Sharing.EARLY,
    holds=Holding.ORBIT,
    takes_accuracy=True,
)
