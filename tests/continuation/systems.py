"""Small systems with solutions in closed form; nothing of models or orbits."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from pddecont.continuation import (
    Approach,
    BranchState,
    CurvePoint,
    End,
    FixedUnknowns,
    Scaling,
    StepSettings,
    TestFunctions,
    find_tangent,
    follow_branch,
)
from pddecont.errors import ConvergenceError
from pddecont.reasons import make_reason


@dataclass(frozen=True, eq=False)
class Evaluated:
    """The equations of an algebraic system at one point."""

    system: Algebraic
    x: np.ndarray

    @cached_property
    def residual(self):
        r = np.asarray(self.system.equations(self.x), dtype=float)
        if not np.all(np.isfinite(r)):
            raise ConvergenceError("the equations have no values here")
        return r

    def jacobian(self):
        matrix = np.asarray(self.system.derivatives(self.x), dtype=float)
        return sp.csc_matrix(matrix) if self.system.sparse else matrix

    time_order = None


@dataclass(frozen=True, eq=False)
class Algebraic:
    """Equations given with their derivatives; ``scale`` and ``weight`` are one by default."""

    equations: object
    derivatives: object
    scale: tuple[float, ...] = (1.0, 1.0)
    weight: tuple[float, ...] = (1.0, 1.0)
    sparse: bool = False

    @property
    def scaling(self):
        return Scaling(np.array(self.scale), np.array(self.weight))

    def at(self, x):
        return Evaluated(self, np.asarray(x, dtype=float))


def circle(**changes):
    """x^2 + y^2 = 1."""
    return Algebraic(lambda x: [x @ x - 1.0], lambda x: [2.0 * x], **changes)


def fold(**changes):
    """x^2 = p in (x, p)."""
    return Algebraic(lambda x: [x[0] ** 2 - x[1]], lambda x: [[2.0 * x[0], -1.0]], **changes)


def line(slope=1.0, **changes):
    """y = slope x: Newton's method takes one step."""
    return Algebraic(lambda x: [x[1] - slope * x[0]], lambda x: [[-slope, 1.0]], **changes)


def crossing(**changes):
    """y (p - y^2) = 0 in (y, p): a parabola crosses the line y = 0 at p = 0."""
    return Algebraic(lambda x: [x[0] * (x[1] - x[0] ** 2)], lambda x: [[x[1] - 3.0 * x[0] ** 2, x[0]]], **changes)


@dataclass(frozen=True, eq=False)
class GridEvaluation:
    """The equations of a growth at one point."""

    system: Growth
    x: np.ndarray

    @property
    def rate(self):
        """The free parameter."""
        return self.x[-1]

    @cached_property
    def residual(self):
        u, step = self.x[:-1], self.rate / self.system.n
        return np.append(u[0] - 1.0, np.diff(u) - 0.5 * step * (u[1:] + u[:-1]))

    def jacobian(self):
        n, step, u = self.system.n, self.rate / self.system.n, self.x[:-1]
        matrix = np.zeros((n + 1, n + 2))
        matrix[0, 0] = 1.0
        rows = np.arange(n)
        matrix[rows + 1, rows], matrix[rows + 1, rows + 1] = -1.0 - 0.5 * step, 1.0 - 0.5 * step
        matrix[1:, -1] = -0.5 / n * (u[1:] + u[:-1])
        return sp.csc_matrix(matrix)

    time_order = None


@dataclass(frozen=True, eq=False)
class Growth:
    """u' = p u, u(0) = 1 by the trapezoidal rule on ``n`` equal intervals of [0, 1], in (u_0 .. u_n, p).

    The solution is u_j = ((1 + p / 2n) / (1 - p / 2n))^j. The grid makes sense while p < 2n (the rule has a pole there)
    and is fine enough while p <= n / 2. ``settles`` False: no grid is. ``asked`` collects what grids were made for
    (solved or not), ``references`` counts how often the system was taken anew from a solution.
    """

    n: int
    settles: bool = True
    asked: list[bool] = field(default_factory=list)
    references: int = 0

    @property
    def scaling(self):
        return Scaling(np.ones(self.n + 2), np.append(np.full(self.n + 1, 1.0 / (self.n + 1)), 1.0))

    def at(self, x):
        return GridEvaluation(self, np.asarray(x, dtype=float))

    @property
    def mesh_independent_index(self):
        return np.array([0, self.n, self.n + 1])

    def mesh_is_valid(self, at):
        return abs(at.rate) < 2.0 * self.n

    def mesh_is_adequate(self, at):
        return self.settles and abs(at.rate) <= 0.5 * self.n

    def remesh(self, at, others, *, solved):
        self.asked.append(solved)
        finer = replace(self, n=int(np.ceil(abs(at.rate) * (4.0 if solved else 1.0))))
        moved = [finer.interpolate_from(self, x) for x in (at.x, *others)]
        return finer, moved[0], moved[1:]

    def interpolate_from(self, other, x):
        if other.n == self.n:
            return x
        grids = (np.linspace(0.0, 1.0, s.n + 1) for s in (self, other))
        return np.append(np.interp(*grids, x[:-1]), x[-1])

    def explain_unsettled_mesh(self):
        return "the grid does not settle"

    def update_reference(self, at, error=None):
        return replace(self, references=self.references + 1)


def grow(n, rate):
    """Return the solution of a growth in closed form."""
    step = 0.5 * rate / n
    return np.append(((1.0 + step) / (1.0 - step)) ** np.arange(n + 1), rate)


@dataclass(frozen=True)
class Margins:
    """A boundary whose margins and their gradients are functions of the unknowns."""

    values: object
    slopes: object
    approach: Approach = Approach.UP_TO
    end: str = End.LIMIT

    def margins(self, at):
        return np.asarray(self.values(at.x), dtype=float)

    def gradients(self, at):
        return np.asarray(self.slopes(at.x), dtype=float)

    def reason(self, at, k):
        return make_reason("used_up", number=k)


@dataclass(frozen=True)
class Range:
    """The unknown at ``index`` stays between two numbers."""

    index: int
    low: float
    high: float
    approach: Approach = Approach.BEYOND
    end: str = End.RANGE

    def margins(self, at):
        return np.array([at.x[self.index] - self.low, self.high - at.x[self.index]])

    def gradients(self, at):
        result = np.zeros((2, len(at.x)))
        result[:, self.index] = 1.0, -1.0
        return result

    def reason(self, at, k):
        return make_reason("range", parameter=f"x{self.index}", value=(self.low, self.high)[k])


def start_at(system, x, towards, step=0.02):
    """Return where a branch stands at one of its points, to be followed ``towards`` a direction."""
    adaptive = system if hasattr(system, "remesh") else FixedUnknowns(system)
    at = adaptive.at(np.asarray(x, dtype=float))
    direction = find_tangent(at, adaptive.scaling, np.asarray(towards, dtype=float))
    return BranchState(CurvePoint(adaptive, at, None, direction), 0.0, step, 1)


def follow(system, x, towards, boundaries, functions=None, *, sign=1, **settings):
    """Return the points of a branch that is followed from ``x`` towards a direction, and how it ended."""
    options, points = StepSettings(**settings), []
    functions = functions or TestFunctions()
    state = start_at(system, x, towards, options.initial)
    return points, follow_branch(state, boundaries, functions, options, points.append, sign)
