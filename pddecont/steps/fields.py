"""Parts that several kinds of steps write alike: ranges, grids, lists, multipliers."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from pddecont.model import Formula, Strict


def _check_range(value: Any) -> Any:
    if not isinstance(value, list) or len(value) != 2:
        raise PydanticCustomError("range", "expected a list of two numbers: [lowest, highest]", {})
    return value


def _check_grid(value: Any) -> Any:
    if not isinstance(value, list) or len(value) != 3:
        raise PydanticCustomError("grid", "expected a list of three: [lowest, highest, how many]", {})
    n = value[2]
    if isinstance(n, bool) or not isinstance(n, int | float) or n != int(n) or not 1 <= n <= 100_000:
        raise PydanticCustomError(
            "grid", "the third, how many values there are, is a whole number from 1 to 100000", {}
        )
    return value


Range = Annotated[list[Formula], BeforeValidator(_check_range)]
Grid = Annotated[list[Formula], BeforeValidator(_check_grid)]
Several = Annotated[
    list[Annotated[int, Field(ge=1)]], BeforeValidator(lambda v: v if isinstance(v, list) else [v]), Field(min_length=1)
]


class Stability(Strict):
    """How many Floquet multipliers are computed."""

    multipliers: int = Field(ge=1, le=200, description="number of leading multipliers")


def _check_stability(value: Any) -> Any:
    if not isinstance(value, (bool, dict, Stability)):
        raise PydanticCustomError(
            "stability",
            "expected true, false, or {some}; found {value}",
            {"some": "{multipliers: N}", "value": repr(value)},
        )
    return value


StabilityChoice = Annotated[
    bool | Stability,
    BeforeValidator(_check_stability),
    Field(
        description=(
            "Floquet multipliers: true for those of modulus above 1e-3 (at most 12), or {multipliers: N} for the N "
            "leading ones"
        )
    ),
]
Verify = Annotated[
    bool | None,
    Field(
        description="simulate each orbit for one period, from its own past in each segment, and compare (default: true)"
    ),
]
