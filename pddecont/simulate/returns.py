"""Where and when the returns of a motion are counted."""

from __future__ import annotations

from dataclasses import dataclass

import sympy


@dataclass(frozen=True)
class ReturnSection:
    """Where returns are counted: at an event of the model, or where an expression crosses zero in a direction.

    Without either, returns are counted by the forcing.
    """

    event: str | None = None
    expr: sympy.Expr | None = None
    direction: str = "rising"


@dataclass(frozen=True)
class ReturnSettings:
    """When returns come and how long they are awaited.

    Attributes
    ----------
    forcing_period
        The period of the forcing, by which returns are counted; 0 where they are counted at the section.
    phase
        The part of the forcing period that has passed at a return.
    transient
        The longest time for settling.
    max_period
        The longest period, in returns.
    n_kept
        How many returns are kept of a motion without a period.
    """

    forcing_period: float
    phase: float
    transient: float
    max_period: int
    n_kept: int
