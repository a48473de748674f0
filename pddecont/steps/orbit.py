"""The ``orbit`` step: the periodic orbit that a trajectory has settled to, or a recorded orbit solved anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import Field

from pddecont.errors import SignatureError
from pddecont.model import SegmentName, Strict, check_signature
from pddecont.results import ORBIT
from pddecont.runfile import From, Holding, Path, StepInput
from pddecont.steps.fields import Stability, StabilityChoice, Verify
from pddecont.steps.kind import StepKind


class Orbit(Strict):
    """Find the periodic orbit that a trajectory has settled to, or solve a recorded orbit anew."""

    from_: From = Field(alias="from", description="a simulate step, an attractor of a sweep or basin, or an orbit")
    signature: list[SegmentName] | None = Field(None, description="segments that the orbit must have")
    stability: StabilityChoice = False
    verify: Verify = None


@dataclass(frozen=True)
class MultiplierSettings:
    """Whether Floquet multipliers are computed, and how many (None: those that are not small)."""

    wanted: bool = False
    number: int | None = None


@dataclass(frozen=True, eq=False)
class OrbitSettings:
    """What an orbit step does.

    ``signature`` is what the orbit must have (None: any); ``verifies`` whether it is simulated from its own past.
    """

    signature: tuple[str, ...] | None
    multipliers: MultiplierSettings
    verifies: bool


def resolve_orbit(given: StepInput[Orbit]) -> OrbitSettings:
    """Return what an orbit step does; note what is wrong with it."""
    signature = resolve_signature(given, ("signature",), given.body.signature)
    return OrbitSettings(signature, resolve_multipliers(given.body.stability), given.body.verify is not False)


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
    holds=Holding.ORBIT,
    integrates=True,
    takes_accuracy=True,
)
