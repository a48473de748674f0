"""What goes out to workers: a model and how it is integrated, and where motions start."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.delay.operator import DelayMethod
from pddecont.model.codegen import NumericModel
from pddecont.model.system import Model
from pddecont.simulate.simulator import Method, Section, Simulator

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Task:
    """What all chunks of a step share: a model and how it is integrated. Tasks with one ``token`` and delay method are one."""

    model: Model = field(compare=False, hash=False)
    delay: DelayMethod
    method: Method = field(compare=False, hash=False)
    section: Section = field(compare=False, hash=False)
    history: tuple[sympy.Expr, ...] | None = field(compare=False, hash=False)
    token: str

    def simulator(self) -> Simulator:
        """Return a simulator of its own for whoever asks: intermediate results are not shared."""
        return Simulator(_numeric(self), self.delay, self.method, self.section, self.history)


@lru_cache(maxsize=8)
def _numeric(task: Task) -> NumericModel:
    return NumericModel(task.model)


@dataclass(frozen=True, eq=False)
class Start:
    """Where a motion starts: states (n,), mode, and whether they are its history too."""

    states: Array
    mode: str
    constant: bool
