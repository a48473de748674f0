"""Periodic orbits as a system of equations for the continuation: residual, Jacobian, sizes, new meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric
from pddecont.continuation.linear import Matrix
from pddecont.continuation.newton import NewtonSettings, Solution, newton
from pddecont.errors import ConvergenceError
from pddecont.orbit.error import interval_errors, state_sizes
from pddecont.orbit.finite import why_not_finite
from pddecont.orbit.jacobian import Assembler
from pddecont.orbit.meshing import Density, MeshRule, density_of, fits, good_enough, new_mesh, on_mesh
from pddecont.orbit.problem import INSTANT, OrbitProblem, Reads, read
from pddecont.orbit.residual import residual

Array = NDArray[np.float64]


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
    rule: MeshRule | None = None
    density: Density | None = None

    def __post_init__(self) -> None:
        self.assembler = Assembler(self.problem)
        self._last: tuple[Array, Reads] | None = None

    def _reads(self, x: Array) -> Reads:
        if self._last is None or self._last[0] is not x:
            self._last = (x, read(self.problem, x, self.problem.mesh.sites))
        return self._last[1]

    def residual(self, x: Array) -> Array:
        """Return the residual of the unknowns ``x``; raise ConvergenceError, naming the expression, where it is not finite."""
        reads = self._reads(x)
        r = residual(self.problem, x, reads)
        if not np.all(np.isfinite(r)):
            raise ConvergenceError(why_not_finite(self.problem, reads))
        return r

    def jacobian(self, x: Array) -> Matrix:
        """Return its derivatives; raise ConvergenceError, naming the expression, where they are not finite."""
        matrix = self.assembler(x, self._reads(x))
        if not np.all(np.isfinite(matrix.data if sp.issparse(matrix) else matrix)):
            raise ConvergenceError(why_not_finite(self.problem, self._reads(x), derivatives=True))
        return matrix

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

    def outline(self, x: Array) -> Array:
        """Return the unknowns that no mesh changes: states at the segments' starts, durations, start, free parameters."""
        return x[self.outline_index()]

    def outline_index(self) -> NDArray[np.intp]:
        """Return the places of :meth:`outline` among the unknowns."""
        layout = self.problem.layout
        return np.concatenate([layout.value_index[self.problem.mesh.first_base].ravel(), np.arange(layout.durations.start, layout.size)])

    def forbids(self, x: Array) -> str:
        """Return which segment has no duration left at ``x``; empty if all have."""
        durations = x[self.problem.layout.durations]
        if np.all(durations > INSTANT * np.sum(durations)):
            return ""
        s = int(np.argmin(durations))
        return f"segment {s + 1} ({self.problem.segments[s].name}) vanishes"

    def holds(self, x: Array) -> bool:
        """Whether the mesh's breaking points are in their order at ``x``."""
        return self.rule is None or fits(self.problem, x)

    def suits(self, x: Array) -> bool:
        """Whether the mesh holds at the orbit ``x`` and keeps its tolerance."""
        return self.rule is None or (fits(self.problem, x) and good_enough(self.problem, x, self.rule))

    def refit(self, x: Array, others: Sequence[Array], *, solved: bool) -> tuple[Curve, Array, list[Array]]:
        """Return the curve on a mesh made for ``x``, with ``x`` and ``others`` in its unknowns.

        A solution (``solved``) tells where intervals are wanted; a guess gets them where the last solution wanted them.
        """
        assert self.rule is not None
        density = self.density
        if self.rule.tol is not None and (density is None or (solved and fits(self.problem, x))):
            density = density_of(self.problem, x, self.rule)
        mesh = new_mesh(self.problem, self.problem.theta(x), self.rule, density)
        problem, moved = on_mesh(self.problem, x, mesh)
        curve = Curve(problem, self.sizes, self.rule, density)
        return curve, moved, [on_mesh(self.problem, other, mesh)[1] for other in others]

    def carry(self, other: Curve, x: Array) -> Array:
        """Return the orbit ``x`` of another curve with the same signature in this one's unknowns."""
        return x if other.problem.mesh is self.problem.mesh else on_mesh(other.problem, x, self.problem.mesh)[1]

    def rephased(self, x: Array) -> Curve:
        """Return the curve with the orbit ``x`` as the reference of its phase and of where its mesh is fine."""
        problem, density = self.problem, self.density
        if problem.reference is not None:
            problem = replace(problem, reference=problem.layout.split(x)[0])
        if self.rule is not None and self.rule.tol is not None:
            density = density_of(problem, x, self.rule)
        curve = Curve(problem, self.sizes, self.rule, density)
        curve.assembler.blocks = self.assembler.blocks
        return curve


MAX_MESHES = 8


def settle(problem: OrbitProblem, guess: Array, rule: MeshRule, settings: NewtonSettings | None = None) -> tuple[OrbitProblem, Solution]:
    """Return the periodic orbit near ``guess``, all parameters fixed, on a mesh that suits it.

    Raises
    ------
    ConvergenceError
        If Newton's method fails, or no mesh reaches the rule's tolerance.
    """
    for _ in range(MAX_MESHES):
        if not fits(problem, guess):
            problem, guess = on_mesh(problem, guess, new_mesh(problem, problem.theta(guess), rule))
        solution = solve_orbit(problem, guess, settings)
        curve = Curve(problem, sizes_of(problem, solution.x), rule)
        if curve.suits(solution.x):
            return problem, solution
        solved = problem
        curve, guess, _ = curve.refit(solution.x, [], solved=True)
        problem = curve.problem
    worst = float(np.max(interval_errors(solved, solution.x)))
    raise ConvergenceError(f"no mesh reaches the tolerance: {solved.mesh.n_intervals} intervals leave an estimated error of {worst:.1e}; "
                           "raise 'mesh: {tol}' or the degree")  # fmt: skip


def solve_orbit(problem: OrbitProblem, guess: Array, settings: NewtonSettings | None = None) -> Solution:
    """Return the periodic orbit near ``guess`` with all parameters fixed; raise ConvergenceError with the residuals."""
    assert not problem.free, "all parameters are fixed here"
    curve = Curve(problem, sizes_of(problem, guess))
    return newton(curve.residual, curve.jacobian, guess, curve.metric().scale, settings)
