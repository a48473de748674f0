"""Periodic orbits as a system of equations for the continuation: residual, Jacobian, scaling, new meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.collocation import SAFETY, Density, MeshRule, equal_cuts, has_wanted_intervals, share_intervals
from pddecont.continuation import Matrix, Scaling, TimeOrder
from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property
from pddecont.orbit.assembly import Assembly
from pddecont.orbit.error import estimate_interval_errors, measure_states
from pddecont.orbit.jacobian import make_jacobian
from pddecont.orbit.nonfinite import explain_not_finite
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.remesh import (
    anchor_mesh,
    find_density,
    keeps_its_pieces,
    make_mesh,
    mesh_is_valid,
    mesh_meets_tolerance,
    transfer_orbit,
)
from pddecont.orbit.residual import compute_residual
from pddecont.orbit.time_order import order_in_time

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Solutions in a row that a mesh may be too coarse for, and what each one more makes of the error that the next aims at.
USUAL_MESHES, STRICTER = 3, 0.4
# The part of the tolerance beyond which the estimated error of a solution asks for another mesh for the next one.
NEAR_TOLERANCE = 0.5
# Errors of solutions larger than those of their intervals by more than this are told of equations that hardly say where
# a solution is, as near a branch point. Intervals are not asked for less than the second: rounding leaves that.
MOST_GROWTH, LEAST_TOLERANCE = 1e3, 1e-12
# After so many meshes in a row that were too coarse, growth asks for no other.
GROWTH_MESHES = 2


@dataclass(frozen=True, eq=False)
class Sizes:
    """What counts as length one: each state's size (n_states,), the period, the width of each parameter's range."""

    states: Array
    period: float
    ranges: tuple[float, ...] = ()


def measure_orbit(orbit: Orbit, ranges: tuple[float, ...] = ()) -> Sizes:
    """Return the sizes of an orbit."""
    return Sizes(measure_states(orbit.values), orbit.period, ranges)


@dataclass(frozen=True, eq=False)
class OrbitEvaluation:
    """The equations of a system of orbits at one orbit."""

    system: PeriodicOrbitSystem
    orbit: Orbit

    @property
    def x(self) -> Array:
        """The unknowns."""
        return self.orbit.x

    @cached_property
    def residual(self) -> Array:
        """The residuals.

        Raises
        ------
        ConvergenceError
            Where they are not finite, with the expression that is not.
        """
        r = compute_residual(self.orbit)
        if not np.isfinite(r).all():
            raise ConvergenceError(explain_not_finite(self.orbit))
        return r

    def jacobian(self) -> Matrix:
        """Return the residuals' derivatives.

        Raises
        ------
        ConvergenceError
            Where they are not finite, with the expression that is not.
        """
        matrix = make_jacobian(self.orbit, self.system.places)
        if not np.isfinite(matrix.data if sp.issparse(matrix) else matrix).all():
            raise ConvergenceError(explain_not_finite(self.orbit, derivatives=True))
        return matrix

    @property
    def time_order(self) -> TimeOrder | None:
        """In which order of time the Jacobian is eliminated."""
        return order_in_time(self.orbit.problem)


@dataclass(frozen=True, eq=False)
class PeriodicOrbitSystem:
    """The orbits of one problem with its free parameters.

    ``rule`` says how its meshes are made (None: the mesh stays), ``density`` where the last solution wanted its
    intervals; ``places`` holds those of the last Jacobian's entries. ``n_coarse`` counts the meshes in a row that were
    too coarse for the solutions found on them. ``outlived`` says that the next orbit gets another mesh.
    ``growth`` is by how much the last solution's error was larger than those of its intervals: orbits pass errors on.
    ``known`` is an orbit of the same problem of which much is worked out already.
    """

    problem: OrbitProblem
    sizes: Sizes
    rule: MeshRule | None = None
    density: Density | None = None
    places: dict[str, Assembly] = field(default_factory=dict, repr=False)
    n_coarse: int = 0
    outlived: bool = False
    growth: float = 1.0
    known: Orbit | None = field(default=None, repr=False)

    def at(self, x: Array) -> OrbitEvaluation:
        """Return the equations at the unknowns ``x``."""
        known = self.known
        return OrbitEvaluation(self, Orbit(self.problem, x) if known is None or known.x is not x else known)

    @cached_property
    def scaling(self) -> Scaling:
        """Sizes and weights of the unknowns: all base values together count as much as all durations."""
        unknowns, sizes = self.problem.unknowns, self.sizes
        scale, weight = np.ones(unknowns.size), np.ones(unknowns.size)
        scale[unknowns.value_index] = sizes.states
        weight[unknowns.values] = 1.0 / unknowns.values.stop
        scale[unknowns.moving] = scale[unknowns.start] = sizes.period
        weight[unknowns.durations] = 1.0 / (unknowns.durations.stop - unknowns.durations.start)
        weight[unknowns.breaking] = 0.0
        scale[unknowns.free] = sizes.ranges
        return Scaling(scale, weight)

    @cached_property
    def mesh_independent_index(self) -> Ints:
        """Places of the states at the segments' starts, durations, start and free parameters."""
        unknowns = self.problem.unknowns
        starts = unknowns.value_index[self.problem.mesh.first_base].ravel()
        return np.concatenate([starts, unknowns.mesh_independent])

    @property
    def order_independent_index(self) -> Ints:
        """Places of durations, start and free parameters: a state at an event has a corner where one passes it."""
        return self.problem.unknowns.mesh_independent

    def mesh_is_valid(self, at: OrbitEvaluation) -> bool:
        """Return whether the mesh's breaking points are in their order at an orbit, and it is not to be replaced."""
        return self.rule is None or (not self.outlived and mesh_is_valid(at.orbit))

    def mesh_is_adequate(self, at: OrbitEvaluation) -> bool:
        """Return whether the mesh is valid at an orbit and keeps its tolerance."""
        return self.rule is None or (mesh_is_valid(at.orbit) and self._meets_tolerance(at.orbit))

    def remesh(
        self, at: OrbitEvaluation, others: Sequence[Array], *, solved: bool
    ) -> tuple[PeriodicOrbitSystem, Array, list[Array]]:
        """Return the system on a mesh made for an orbit, with that orbit and ``others`` in its unknowns.

        A solution (``solved``) tells where intervals are wanted; a guess gets them where the last solution wanted them.
        Where meshes made for solutions turn out too coarse again and again, as where steep parts are read by delays
        that vary, they are made for less and less of an error. Where breaking points are in their order still and the
        mesh is fine enough, it is kept, and only what is read of the past moves to other intervals.
        """
        assert self.rule is not None
        orbit, density, n_coarse = at.orbit, self.density, self.n_coarse + solved
        if self._keeps_mesh(orbit, solved):
            anchored = anchor_mesh(orbit)
            problem = anchored.problem
            return replace(self, problem=problem, n_coarse=n_coarse, known=None), anchored.x, list(others)
        if self.rule.tol is not None and (density is None or (solved and mesh_is_valid(orbit))):
            aim = _aim_at(self.rule.tol, self.growth)
            density = find_density(orbit, aim * STRICTER ** max(0, n_coarse - USUAL_MESHES))
        mesh = make_mesh(self.problem, orbit.theta, self.rule, density, orbit)
        moved = transfer_orbit(orbit, mesh)
        system = PeriodicOrbitSystem(
            moved.problem, self.sizes, self.rule, density, self.places, n_coarse=n_coarse, growth=self.growth
        )
        carried = [moved.x if other is at.x else transfer_orbit(Orbit(self.problem, other), mesh).x for other in others]
        return system, moved.x, carried

    def interpolate_from(self, other: PeriodicOrbitSystem, x: Array) -> Array:
        """Return the orbit ``x`` of another system with the same signature in this one's unknowns."""
        if self.problem.mesh.has_base_points_of(other.problem.mesh):
            return x
        return transfer_orbit(Orbit(other.problem, x), self.problem.mesh).x

    def update_reference(self, at: OrbitEvaluation, error: float | None = None) -> PeriodicOrbitSystem:
        """Return the system with an orbit as the reference of its phase and of where its mesh is fine."""
        orbit, density, outlived, growth = at.orbit, self.density, False, 1.0
        if self.rule is not None and self.rule.tol is not None:
            if error is not None and np.isfinite(error):
                growth = _measure_growth(orbit, error, self.rule.tol)
            density = find_density(orbit, _aim_at(self.rule.tol, growth))
            near = error is not None and error > NEAR_TOLERANCE * self.rule.tol
            outlived = near or not has_wanted_intervals(orbit.mesh, orbit.theta, density)
        problem, known = self.problem, orbit if orbit.problem is self.problem else None
        if problem.reference is not None:
            problem, known = replace(problem, reference=orbit.values), None
        return PeriodicOrbitSystem(
            problem, self.sizes, self.rule, density, self.places, outlived=outlived, growth=growth, known=known
        )

    def _meets_tolerance(self, orbit: Orbit) -> bool:
        """Return whether a mesh keeps the tolerance for a solution, whose error is taken to grow as the last one's."""
        assert self.rule is not None
        growth = self.growth if self.n_coarse < GROWTH_MESHES else 1.0
        return mesh_meets_tolerance(orbit, None if self.rule.tol is None else self.rule.tol / growth)

    def _keeps_mesh(self, orbit: Orbit, solved: bool) -> bool:
        """Return whether an orbit needs no other mesh than the one that it is on."""
        assert self.rule is not None
        # A mesh that is not settled by moving what is read is made anew.
        same = orbit.mesh.degree == self.rule.degree and not (self.outlived or self.n_coarse)
        if not same or not keeps_its_pieces(orbit):
            return False
        if self.rule.intervals is None:
            return not solved or self._meets_tolerance(orbit)
        lengths = orbit.mesh.piece_lengths @ orbit.theta
        shares = share_intervals(lengths, max(self.rule.intervals, len(lengths)))
        cuts = equal_cuts(shares)
        return all(np.array_equal(piece.cuts, c) for piece, c in zip(orbit.mesh.pieces, cuts, strict=True))

    def explain_unsettled_mesh(self) -> str:
        """Return what it means if no mesh is adequate for the orbit found on it."""
        return (
            "the mesh does not settle: a delayed value is read across a jump of the state here, or 'mesh: {tol}' is "
            "too small"
        )


def _measure_growth(orbit: Orbit, error: float, tol: float) -> float:
    """Return by how much the ``error`` of an orbit is larger than those of its intervals, as far as meshes tell."""
    most, largest = min(MOST_GROWTH, tol / LEAST_TOLERANCE), float(np.max(estimate_interval_errors(orbit)))
    return max(1.0, min(most, error / largest if largest > 0.0 else 1.0))


def _aim_at(tol: float, growth: float) -> float:
    """Return the errors that intervals are to leave at most, so that the solution's own stays below ``tol``.

    A mesh is made for a part of what is asked for; growth that this part makes up for asks for nothing more.
    """
    return tol * min(1.0, NEAR_TOLERANCE / (SAFETY * growth))
