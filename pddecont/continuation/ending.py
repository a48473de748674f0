"""How a branch ends, in words with advice."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class End(Enum):
    """Why a branch ends, with advice."""

    RANGE = "reached the end of the range; widen 'range' to go on"
    MAX_POINTS = "reached 'max_points'; raise it, or 'step: {max}', to go on"
    STEP_TOO_SMALL = ("the step fell below 'step: {min}'; look at the last orbits for a grazing, a vanishing segment or a sharp "
                      "fold, refine 'mesh', or lower 'step: {min}'")  # fmt: skip
    IMPOSSIBLE = "can go no further with this signature"
    LIMIT = "reached a limit of the model"
    SPECIAL = "stopped at a special point where the signature of the orbit changes"
    INVALID = ("the orbit stops being a motion of the model without a special point that was located; take smaller steps "
               "('step: {max}'), or start anew from a simulation beyond")  # fmt: skip
    RESONANCE = "the curve ends where its pair of multipliers meets on the real axis"


@dataclass(frozen=True)
class Termination:
    """How one direction of a branch ended; ``lost`` counts the changes of stability that no special point accounts for.

    ``where`` names the bound at which a range ended.
    """

    end: End
    detail: str = ""
    lost: int = 0
    where: str = ""

    def __str__(self) -> str:
        lost = f"; WARNING: {self.lost} change{'s'[: self.lost - 1]} of stability not located: take smaller steps" if self.lost else ""
        what, mark, advice = self.end.value.partition("; ")
        return f"{what}{f', {self.where}' if self.where else ''}{mark}{advice}{f' ({self.detail})' if self.detail else ''}{lost}"
