"""What a model reads of the past while all its states stay: present values, no rates, integrals of kernels.

Delays that vary have the lags of the present values; a delay that reads others comes after those.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction, NumericModel
from pddecont.equilibrium.quadrature import find_panels, make_points
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class RestReads:
    """The reads of a model at states x (n_states,) that stay, and parameters p."""

    numeric: NumericModel

    def find_values(self, x: Array, p: Array) -> Array:
        """Return the values of the model's ``read_symbols``, shape (n_reads,).

        Raises
        ------
        ConvergenceError
            If an integral has no finite value.
        """
        values = np.where(self.is_value, x[self.states], 0.0)
        n_integrals = len(self.numeric.model.integrals)
        if not n_integrals:
            return values
        reads = np.append(values, np.full(n_integrals, np.nan))
        # An integral stands after those that its limits read.
        for k in range(n_integrals):
            low, high = self.find_limits(k, x, reads, p)
            reads[len(values) + k] = self._integrate(k, low, high, x, p)
        return reads

    def find_lags(self, x: Array, reads: Array, p: Array) -> Array:
        """Return the constant delays, then those that vary as they are with the values ``reads``, shape (n_delays,)."""
        constant, model = self.numeric.delays.value(p), self.numeric.model
        if not model.varying:
            return constant
        return np.append(constant, self.varying.value(np.zeros(1), x[:, None], reads[:, None], p)[:, 0])

    def find_limits(self, number: int, x: Array, reads: Array, p: Array) -> tuple[float, float]:
        """Return between which lags an integral is taken."""
        low, high = self.numeric.limits(number).value(np.zeros(1), x[:, None], reads[:, None], p)[:, 0].tolist()
        return low, high

    def find_integrand_slopes(self, number: int, x: Array, p: Array) -> Callable[[Array], Array]:
        """Return an integrand's derivatives in the states that :meth:`list_integrated` names, (n_read, n_points)."""
        function = self.numeric.integrand(number)
        return lambda s: function.derivatives(s, np.repeat(x[:, None], len(s), axis=1), np.zeros((0, len(s))), p).dx

    def list_integrated(self, number: int) -> Ints:
        """Return the numbers of the states that an integrand holds (n_read,)."""
        return self.numeric.integrand(number).structure().dx[1]

    @property
    def varying(self) -> ArrayFunction:
        """The delays that vary as a function."""
        return self.numeric.function(self.numeric.model.varying)

    @cached_property
    def states(self) -> Ints:
        """The state of each delayed value (n_delayed,)."""
        return np.array([v.state for v in self.numeric.model.delayed], dtype=np.intp)

    @cached_property
    def is_value(self) -> NDArray[np.bool_]:
        """Which delayed values are values, not rates (n_delayed,)."""
        return np.array([v.derivative == 0 for v in self.numeric.model.delayed], dtype=bool)

    def _integrate(self, number: int, low: float, high: float, x: Array, p: Array) -> float:
        function = self.numeric.integrand(number)

        def kernel(s: Array) -> Array:
            return function.value(s, np.repeat(x[:, None], len(s), axis=1), np.zeros((0, len(s))), p)

        points, weights = make_points(find_panels(kernel, low, high))
        return float((kernel(points) @ weights)[0])
