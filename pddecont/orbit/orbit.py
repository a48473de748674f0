"""A periodic orbit as a value: a problem, its unknowns, and what is read off them, each worked out once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshPoints
from pddecont.delay import DelayOperator, LocalWeights
from pddecont.memo import Memo, cached_property
from pddecont.orbit.integrals import IntegralOperator, make_integral_operator
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.signature import Signature

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reads(Memo):
    """States and what is read of the past, of an orbit at some points of its mesh.

    Shapes: h (n_intervals,) lengths of the intervals, t (n_points,) physical time, x (n_states, n_points), xd
    (n_reads, n_points), lags (n_varying, n_points) the values of delays that vary. ``operators`` are those of constant
    delays, then of those that vary; ``integrals`` those of integrals over the past. ``free`` numbers the orbit's free
    parameters. What is worked out at the points for one matrix is kept for others (:meth:`once`).
    """

    points: MeshPoints
    h: Array
    t: Array
    x: Array
    xd: Array
    operators: list[DelayOperator]
    lags: Array
    integrals: list[IntegralOperator]
    free: tuple[int, ...]

    def list_local_weights(self) -> list[LocalWeights]:
        """Return what reads single mesh intervals, by delays and in integrals."""
        delays = (op.weights for op in self.operators if isinstance(op.weights, LocalWeights))
        return [*delays, *(integral.pairs for integral in self.integrals)]


@dataclass(frozen=True, eq=False)
class Orbit(Memo):
    """The orbit with the unknowns ``x`` of a problem; a solution, or a guess of one.

    Whatever is worked out of it and asked for again is kept with it (:meth:`once`).
    """

    problem: OrbitProblem
    x: Array

    @property
    def numeric(self) -> NumericModel:
        """The model's functions."""
        return self.problem.numeric

    @property
    def mesh(self) -> Mesh:
        """The mesh that the orbit is given on."""
        return self.problem.mesh

    @property
    def signature(self) -> Signature:
        """The segments that the orbit runs through."""
        return self.problem.signature

    @cached_property
    def _parts(self) -> tuple[Array, Array, float, Array]:
        return self.problem.unknowns.split(self.x)

    @property
    def values(self) -> Array:
        """States at the base points, shape (n_base, n_states)."""
        return self._parts[0]

    @property
    def durations(self) -> Array:
        """Segment durations, shape (n_segments,)."""
        return self._parts[1]

    @property
    def start(self) -> float:
        """Physical time at which the first segment begins (0 for an autonomous model)."""
        return self._parts[2]

    @property
    def free(self) -> Array:
        """Values of the free parameters."""
        return self._parts[3]

    @property
    def breaking(self) -> Array:
        """Breaking times of delays that vary, shape (J,)."""
        return self.x[self.problem.unknowns.breaking]

    @cached_property
    def period(self) -> float:
        """The sum of the segment durations."""
        return float(self.durations.sum())

    @cached_property
    def event_times(self) -> Array:
        """Times of the segments' ends from the orbit's start, 0 first, shape (n_segments + 1,)."""
        return np.concatenate([[0.0], np.cumsum(self.durations)])

    @cached_property
    def parameters(self) -> Array:
        """All parameter values, shape (n_parameters,)."""
        p = self.problem.parameters.copy()
        for i, value in zip(self.problem.free_index, self.free.tolist(), strict=True):
            p[i] = value
        return p

    @cached_property
    def theta(self) -> Array:
        """Theta = (T_1..T_S, tau_1..tau_K, b_1..b_J)."""
        delays = self.numeric.delays.value(self.parameters)
        return np.concatenate([self.durations, delays, self.breaking])

    @cached_property
    def equation_reads(self) -> Reads:
        """The orbit at the points where equations hold."""
        return self.read(self.mesh.equation_points)

    @cached_property
    def delayed_values(self) -> Array:
        """What is read of the past at the base points, shape (n_base, n_reads)."""
        mesh = self.mesh
        result = np.empty((mesh.n_base, len(self.numeric.model.read_symbols)))
        result[mesh.base_index.ravel()] = self.read(mesh.base_points).xd.T
        return result

    def read(self, points: MeshPoints, *, delays: bool = True, integrals: bool = True) -> Reads:
        """Return what the orbit is at ``points``, delays read by the problem's method.

        ``delays=False`` leaves the delayed values at zero, for functions that do not use them; ``integrals=False`` the
        integrals alone: no delay depends on one.
        """
        mesh, theta, model = self.mesh, self.theta, self.numeric.model
        t = self.start + mesh.evaluate_times(points, theta)
        x, past = mesh.interpolate(self.values, points).T, np.zeros((len(points), len(model.read_symbols)))
        xd = past.T
        lags = np.zeros((len(model.varying), len(points)))
        operators = self.problem.make_operators(theta, points) if delays else []
        for k, operator in enumerate(operators):
            self._read_delay(k, operator, past)
        for number in range(len(model.varying) if delays else 0):
            lags[number] = self.numeric.varying_delay(number).value(t, x, xd, self.parameters)[0]
            operators.append(self.problem.make_varying_operator(theta, lags[number], points, number))
            self._read_delay(len(model.delays) + number, operators[-1], past)
        found = self._integrate(points, t, x, xd) if delays and integrals else []
        return Reads(points, mesh.evaluate_edges(theta)[1], t, x, xd, operators, lags, found, self.problem.free_index)

    def _integrate(self, points: MeshPoints, t: Array, x: Array, xd: Array) -> list[IntegralOperator]:
        """Return the integrals over the past, with their values written to their rows of ``xd``."""
        found, model, p = [], self.numeric.model, self.parameters
        for number in range(len(model.integrals)):
            limits, integrand = self.numeric.limits(number).value(t, x, xd, p), self.numeric.integrand(number)
            found.append(make_integral_operator(integrand, self.mesh, self.theta, self.values, points, limits, p))
            xd[len(model.delayed) + number] = found[-1].value
        return found

    def _read_delay(self, k: int, operator: DelayOperator, past: Array) -> None:
        """Write what is read by delay number ``k`` to its columns of ``past`` (n_points, n_reads)."""
        for order, states, columns in self.numeric.list_reads(k):
            operator.weights_of(order).read(self.values, states, columns, past)

    def find_segment(self, time: float) -> int:
        """Return the segment that holds a time after the orbit's start, in [0, period]."""
        found = int(np.searchsorted(self.event_times, time, side="right")) - 1
        return min(found, len(self.signature) - 1)

    def with_free(self, free: tuple[str, ...]) -> Orbit:
        """Return the same orbit with other free parameters."""
        problem = replace(self.problem, parameters=self.parameters, free=free)
        unknowns = problem.unknowns.join(
            self.values, self.durations, self.start, self.parameters[list(problem.free_index)], self.breaking
        )
        return Orbit(problem, unknowns)

    def with_phase_reference(self) -> Orbit:
        """Return the orbit as the reference of its own phase, where it needs one."""
        if not self.signature.needs_phase_reference:
            return self
        return Orbit(replace(self.problem, reference=self.values), self.x)
