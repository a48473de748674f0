"""A model whose delayed values are given functions of time, not read from its own past."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.memo import cached_property
from pddecont.simulate.integrator import ParameterValues, System
from pddecont.simulate.simulator import Simulator

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class DrivenSimulator(Simulator):
    """A model whose delayed values are given functions of time.

    They are read from a past that holds one column a delayed value instead of the states, all of them as long ago as
    the one entry of ``tau`` in the parameter values says. It takes the direct method.
    """

    @cached_property
    def system(self) -> System:
        """The model in numbers, delayed value i read from column i."""
        own = super().system
        every = np.arange(len(own.pair_state))
        return own._replace(pair_state=every, pair_delay=0 * every, kept=0 * every, place=every)

    def values(self, p: Array, longest: float = 0.0) -> ParameterValues:
        """Return the model's numbers at parameters ``p``, but for how long ago delayed values are read."""
        values = super().values(p, longest)
        model = self.numeric.model
        longest_step = float(self.numeric.period.value(p)[0]) / 2 if model.forced else self.method.max_step
        return values._replace(max_step=longest_step)

    @property
    def past_columns(self) -> Integers:
        """The columns of a past that delayed values are read from: all, since it holds nothing else."""
        return self.system.place
