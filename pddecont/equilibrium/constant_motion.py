"""Motions of one mode that do not move: the vector field where all delayed values are the present ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod
from pddecont.equilibrium.characteristic import CharacteristicMatrix

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ConstantMotion:
    """A mode of an autonomous model, its delays discretised by ``method``; states x (n_states,), parameters p."""

    numeric: NumericModel
    mode: str
    method: DelayMethod

    def rate(self, x: Array, p: Array) -> Array:
        """Return f(x, x, ..., x; p), shape (n_states,); zero at an equilibrium."""
        return self.numeric.mode(self.mode).value(np.zeros(1), x[:, None], self._read(x), p)[:, 0]

    def linearise(self, x: Array, p: Array) -> CharacteristicMatrix:
        """Return the characteristic matrix at a state that stays."""
        function, model, n = self.numeric.mode(self.mode), self.numeric.model, len(x)
        where, d = function.structure(), function.derivatives(np.zeros(1), x[:, None], self._read(x), p)
        present, delayed = np.zeros((n, n)), np.zeros((len(model.delays), n, n))
        present[where.dx] = d.dx[:, 0]
        for row, i, slope in zip(*where.dxd, d.dxd[:, 0], strict=True):
            delayed[model.delayed[i].delay, row, model.delayed[i].state] += slope
        return CharacteristicMatrix(present, delayed, self.numeric.delays.value(p), self.method)

    def _read(self, x: Array) -> Array:
        """Return the delayed values of a motion that stays at ``x``, shape (n_delayed, 1)."""
        return x[[d.state for d in self.numeric.model.delayed]][:, None]
