"""Lags at rest of delays that vary: where one is negative the equations would read the future."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import Approach, End
from pddecont.equilibrium.equations import Equilibrium, EquilibriumProblem
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]


class AtEquilibrium(Protocol):
    """An evaluation of equations whose first unknowns are states and whose last are free parameters."""

    @property
    def x(self) -> Array:
        """The unknowns."""
        ...

    @property
    def equilibrium(self) -> Equilibrium:
        """What they stand for."""
        ...


@dataclass(frozen=True, eq=False)
class LagBoundary:
    """Lags of delays that vary are not negative at equilibria."""

    problem: EquilibriumProblem
    approach: Approach = Approach.UP_TO
    end: str = End.LIMIT

    def margins(self, at: AtEquilibrium) -> Array:
        """Return the lags."""
        return self._measure(at)[0]

    def gradients(self, at: AtEquilibrium) -> Array:
        """Return their derivatives in the unknowns."""
        _, in_x, in_p = self._measure(at)
        result = np.zeros((len(in_x), len(at.x)))
        result[:, : in_x.shape[1]], result[:, len(at.x) - in_p.shape[1] :] = in_x, in_p
        return result

    def reason(self, at: AtEquilibrium, k: int) -> Reason:
        """Return which delay becomes negative, and at which states and free parameters."""
        model, equilibrium = self.problem.motion.numeric.model, at.equilibrium
        delay = model.varying[self.problem.motion.lag_numbers[k]]
        names = [list(model.parameters)[i] for i in self.problem.free]
        values = dict(zip(model.states, equilibrium.states.tolist(), strict=True))
        held = {s.name for s in delay.free_symbols}
        places = {name: value for name, value in values.items() if name in held}
        places |= dict(zip(names, at.x[len(at.x) - len(names) :].tolist(), strict=True))
        return make_reason(
            "negative_delay", delay=str(delay), **{f"at {name}": value for name, value in places.items()}
        )

    def _measure(self, at: AtEquilibrium) -> tuple[Array, Array, Array]:
        equilibrium, motion = at.equilibrium, self.problem.motion
        return motion.measure(motion.lags, equilibrium.states, equilibrium.parameters, self.problem.free)
