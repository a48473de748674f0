"""Periodic orbits as a system of equations for the continuation: residual, Jacobian, sizes, new meshes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric
from pddecont.continuation.linear import Matrix
from pddecont.continuation.newton import NewtonSettings, Solution, newton
from pddecont.orbit.error import state_sizes
from pddecont.orbit.jacobian import Assembler
from pddecont.orbit.problem import OrbitProblem, Reads, read
from pddecont.orbit.residual import residual

Array = NDArray[np.float64]
Renew = Callable[[OrbitProblem, Array, Array], tuple[OrbitProblem, Array, Array]]


@dataclass(frozen=True, eq=False)
class Sizes:
    """What counts as length one along a branch: each state's size, the period, the width of each free parameter's range."""

    states: Array
    period: float
    ranges: tuple[float, ...] = ()


def sizes_of(problem: OrbitProblem, x: Array, ranges: tuple[float, ...] = ()) -> Sizes:
    """Return the sizes of the orbit ``x``."""
    values, durations, _, _ = problem.layout.split(x)
    return Sizes(state_sizes(values), float(np.sum(durations)), ranges)


@dataclass(eq=False)
class Curve:
    """The orbits of one problem with its free parameters; keeps the last orbit read, so that it is read once a step."""

    problem: OrbitProblem
    sizes: Sizes
    renewal: Renew | None = None

    def __post_init__(self) -> None:
        self._assembler = Assembler(self.problem)
        self._last: tuple[Array, Reads] | None = None

    def _reads(self, x: Array) -> Reads:
        if self._last is None or self._last[0] is not x:
            self._last = (x, read(self.problem, x, self.problem.mesh.sites))
        return self._last[1]

    def residual(self, x: Array) -> Array:
        """Return the residual of the unknowns ``x``."""
        return residual(self.problem, x, self._reads(x))

    def jacobian(self, x: Array) -> Matrix:
        """Return its derivatives."""
        return self._assembler(x, self._reads(x))

    @cached_property
    def _metric(self) -> Metric:
        layout, sizes = self.problem.layout, self.sizes
        scale, weight = np.ones(layout.size), np.ones(layout.size)
        scale[layout.value_index] = sizes.states
        weight[layout.values] = 1.0 / layout.values.stop
        scale[layout.durations] = scale[layout.start] = sizes.period
        weight[layout.durations] = 1.0 / (layout.durations.stop - layout.durations.start)
        scale[layout.free] = sizes.ranges
        return Metric(scale, weight)

    def metric(self) -> Metric:
        """Return sizes and weights of the unknowns."""
        return self._metric

    def renew(self, x: Array, tangent: Array) -> tuple[Curve, Array, Array]:
        """Return the curve for the next step: the same, or one on a new mesh."""
        if self.renewal is None:
            return self, x, tangent
        problem, new_x, new_tangent = self.renewal(self.problem, x, tangent)
        if problem is self.problem:
            return self, x, tangent
        return Curve(problem, self.sizes, self.renewal), new_x, new_tangent


def solve_orbit(problem: OrbitProblem, guess: Array, settings: NewtonSettings | None = None) -> Solution:
    """Return the periodic orbit near ``guess`` with all parameters fixed; raise ConvergenceError with the residuals."""
    assert not problem.free, "all parameters are fixed here"
    curve = Curve(problem, sizes_of(problem, guess))
    return newton(curve.residual, curve.jacobian, guess, curve.metric().scale, settings)
