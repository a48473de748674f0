"""What a branch cannot pass: the ends of ranges, delays of zero, segments that vanish.

Each boundary is a set of margins, scalars that are positive on the branch and zero where it ends. They differ in how
near a step may come:

    BEYOND    the equations hold on both sides; a step may pass the boundary and is taken back onto it
    UP_TO     the equations hold on this side; no step passes, and a prediction that would is taken back
    TOWARDS   the equations fail at the boundary itself; steps become small before it

Special points that end a branch are boundaries too; they have test functions instead of margins, since they are located
between two points of the branch (``TestFunction.end``).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.adaptive import solve_adaptively
from pddecont.continuation.arclength import solve_with_row
from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.system import AdaptiveSystem, E, Evaluation
from pddecont.errors import ConvergenceError
from pddecont.reasons import Reason

Array = NDArray[np.float64]
# A margin smaller than this, where it changes by one over a length of one along the branch, is zero.
ZERO = 1e-12
# Newton solutions on the way to a curved boundary; each squares the distance.
MAX_TRIES = 6
E_contra = TypeVar("E_contra", bound=Evaluation, contravariant=True)


class Approach(Enum):
    """How near to a boundary the equations hold."""

    BEYOND = auto()
    UP_TO = auto()
    TOWARDS = auto()


class Boundary(Protocol[E_contra]):
    """Margins that end a branch where one becomes zero."""

    @property
    def approach(self) -> Approach:
        """How near a step may come."""
        ...

    @property
    def end(self) -> str:
        """Code of the end of a branch that reaches it."""
        ...

    def margins(self, at: E_contra) -> Array:
        """Return the margins, shape (n_margins,)."""
        ...

    def gradients(self, at: E_contra) -> Array:
        """Return the margins' derivatives, shape (n_margins, n_unknowns)."""
        ...

    def reason(self, at: E_contra, k: int) -> Reason:
        """Return what it means that margin ``k`` is zero."""
        ...


class OutOfReachError(ConvergenceError):
    """What comes next lies beyond a boundary where the equations fail."""

    def __init__(self, end: str, reason: Reason):
        self.end, self.reason = end, reason
        super().__init__(f"the branch ends here ({reason.code})")


def refuse_out_of_reach(boundaries: Sequence[Boundary[E]], at: E) -> None:
    """Raise :class:`OutOfReachError` if ``at`` lies where the equations fail."""
    for boundary in boundaries:
        if boundary.approach is Approach.TOWARDS:
            margins = boundary.margins(at)
            if not np.all(margins > 0.0):
                raise OutOfReachError(boundary.end, boundary.reason(at, int(np.argmin(margins))))


def find_passed(
    boundaries: Sequence[Boundary[E]], approach: Approach, before: CurvePoint[E], after: CurvePoint[E]
) -> tuple[Boundary[E], int, float] | None:
    """Return the first margin of boundaries of one kind that is passed between two points on the way.

    Returns
    -------
    boundary, k, fraction
        The boundary, its margin and the fraction of the way at which it would be zero if it changed evenly; None if no
        margin is negative at ``after``.
    """
    first: tuple[Boundary[E], int, float] | None = None
    for boundary in boundaries:
        if boundary.approach is not approach:
            continue
        values = boundary.margins(after.at)
        for k in np.flatnonzero(values < -_zeros(boundary, after.system, after.at)).tolist():
            start = max(float(boundary.margins(before.at)[k]), 0.0)
            fraction = start / (start - float(values[k]))
            if first is None or fraction < first[2]:
                first = boundary, k, fraction
    return first


def find_reached(
    boundaries: Sequence[Boundary[E]], point: CurvePoint[E], direction: Array
) -> tuple[str, Reason] | None:
    """Return the end and the reason of a boundary that steps come up to, reached at ``point`` and crossed beyond."""
    for boundary in boundaries:
        if boundary.approach is Approach.UP_TO:
            small = boundary.margins(point.at) <= _zeros(boundary, point.system, point.at)
            ending = np.flatnonzero(small & (boundary.gradients(point.at) @ direction < 0.0))
            if len(ending):
                return boundary.end, boundary.reason(point.at, int(ending[0]))
    return None


def land(
    boundary: Boundary[E], k: int, system: AdaptiveSystem[E], guess: Array, settings: NewtonSettings
) -> CurvePoint[E]:
    """Return the branch's point near ``guess`` at which margin ``k`` of a boundary is zero.

    Raises
    ------
    ConvergenceError
        If there is none to be found.
    """

    def solve(on_mesh: AdaptiveSystem[E], start: Array, _: list[Array]) -> Solution[E]:
        here = on_mesh.at(start)
        row = boundary.gradients(here)[k]
        return solve_with_row(on_mesh, row, float(row @ start - boundary.margins(here)[k]), start, settings)

    for _ in range(MAX_TRIES):
        system, solution = solve_adaptively(system, guess, solve)
        guess = solution.x
        # A range is linear in the unknowns: one solution lies on its end, to rounding.
        if boundary.approach is Approach.BEYOND:
            return CurvePoint(system, solution.at, solution)
        if abs(boundary.margins(solution.at)[k]) <= _zeros(boundary, system, solution.at)[k]:
            return CurvePoint(system, solution.at, solution)
    raise ConvergenceError("the end of the branch is not found")


def _zeros(boundary: Boundary[E], system: AdaptiveSystem[Any], at: E) -> Array:
    """Return how little counts as zero of each margin; nothing for ranges, whose ends are exact numbers."""
    gradients = boundary.gradients(at)
    if boundary.approach is Approach.BEYOND:
        return np.zeros(len(gradients))
    return np.asarray(ZERO * np.linalg.norm(gradients * system.scaling.size, axis=1))
