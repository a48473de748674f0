"""What goes out to workers: a model and how it is integrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod
from pddecont.simulate.method import Method
from pddecont.simulate.returns import ReturnSection
from pddecont.simulate.simulator import Simulator

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MotionTask:
    """What all chunks of a step share: a model and how it is integrated; a worker gets it once.

    ``history`` replaces the model's history.
    """

    numeric: NumericModel
    delay: DelayMethod
    method: Method
    section: ReturnSection
    history: tuple[sympy.Expr, ...] | None = None

    def make_simulator(self) -> Simulator:
        """Return a simulator for one thread: intermediate results are its own, the model's functions are shared."""
        return Simulator(self.numeric, self.delay, self.method, self.section, self.history)
