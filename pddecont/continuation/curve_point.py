"""A point of a branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.newton import Solution
from pddecont.continuation.system import AdaptiveSystem, E
from pddecont.memo import cached_property

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CurvePoint(Generic[E]):
    """A point of a branch with the system that it solves, and the equations there.

    ``direction`` is the branch's tangent where it is known; a corrected point has it from its last Newton step.
    """

    system: AdaptiveSystem[E]
    at: E
    solution: Solution[Any] | None = None
    direction: Array | None = None

    @property
    def x(self) -> Array:
        """The unknowns."""
        return self.at.x

    @property
    def n_iterations(self) -> int:
        """Number of Newton steps that it took."""
        return self.solution.n_iterations if self.solution else 0

    @property
    def solve_nearly(self) -> Callable[[Array], Array] | None:
        """What solves with the bordered Jacobian here to a few per cent, None where its factors are not at hand.

        The factors are those of the last Newton step: steps with them led here, each far shorter than the one before.
        """
        if self.solution is None or self.solution.at is not self.at:
            return None
        factors = self.solution.factors
        return self.solution.solve if factors is None else factors.solve

    @cached_property
    def tangent(self) -> Array:
        """The branch's tangent, of any length, on the side to which the row that bordered the Jacobian grows."""
        if self.direction is not None:
            return self.direction
        assert self.solution is not None, "only a corrected point knows its tangent"
        last = np.zeros(len(self.x))
        last[-1] = 1.0
        return self.solution.solve(last)

    def without_factors(self) -> CurvePoint[E]:
        """Return the point with its tangent, and without the factors that told it, which are large."""
        if self.solution is None:
            return self
        point = replace(self, solution=self.solution.without_factors())
        vars(point)["tangent"] = self.tangent
        return point

    @property
    def mesh_independent_unknowns(self) -> Array:
        """The unknowns that no mesh changes."""
        return self.x[self.system.mesh_independent_index]
