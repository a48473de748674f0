"""What a periodic orbit must satisfy: signature, mesh, delay method, parameters, of which some are free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshPoints
from pddecont.delay import DelayMethod, DelayOperator
from pddecont.memo import cached_property
from pddecont.model import Segment
from pddecont.orbit.signature import DelayedEventLink, Signature
from pddecont.orbit.unknowns import Unknowns

Array = NDArray[np.float64]
# A segment shorter than this many periods has no duration: rounding decides on its sign.
INSTANT = 1e-12


@dataclass(frozen=True, eq=False)
class OrbitProblem:
    """The boundary-value problem of one signature on one mesh (``docs/mathematics/boundary_value_problem.md``).

    ``parameters`` holds all parameter values, of which those named in ``free`` are replaced by unknowns. ``n_periods``
    is k in sum T_s = k * forcing period. ``reference`` fixes the phase of an orbit without events: base values z_ref
    (n_base, n_states) with integral z . z_ref' = 0 for an autonomous model; a forced one starts at t_0 = ``phase``.
    ``links`` says what started each delayed event that ends a segment.
    """

    signature: Signature
    mesh: Mesh
    delay: DelayMethod
    parameters: Array
    free: tuple[str, ...] = ()
    n_periods: int = 1
    reference: Array | None = None
    phase: float = 0.0
    links: tuple[DelayedEventLink, ...] = ()

    @property
    def numeric(self) -> NumericModel:
        """The model's functions."""
        return self.signature.numeric

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The signature's segments."""
        return self.signature.segments

    @cached_property
    def unknowns(self) -> Unknowns:
        """Places of the unknowns."""
        counts = self.numeric.n_states, self.numeric.model.forced, len(self.free)
        return self.mesh.once(("unknowns", counts), lambda: Unknowns(self.mesh, *counts))

    @cached_property
    def free_index(self) -> tuple[int, ...]:
        """Places of the free parameters among all parameters."""
        return tuple(map(self.numeric.parameter_index, self.free))

    @cached_property
    def lags(self) -> Array:
        """Coefficients of theta = (T_1..T_S, tau_1..tau_K, b_1..b_J) in each constant delay, shape (K, S + K + J)."""
        n, k = self.mesh.n_segments, len(self.numeric.model.delays)
        return np.eye(k, n + k + self.mesh.n_breaking, k=n)

    @cached_property
    def orders(self) -> tuple[int, ...]:
        """The highest derivative that is read by each delay, constant or varying."""
        model = self.numeric.model
        n = len(model.delays) + len(model.varying)
        return tuple(max([d.derivative for d in model.delayed if d.delay == k], default=0) for k in range(n))

    def make_operators(self, theta: Array, points: MeshPoints) -> list[DelayOperator]:
        """Return one operator a constant delay at ``theta`` for reads at ``points``."""
        return [
            self.delay.operator(self.mesh, theta, lag, points, orders=orders)
            for lag, orders in zip(self.lags, self.orders, strict=False)
        ]

    def make_varying_operator(self, theta: Array, lags: Array, points: MeshPoints, number: int) -> DelayOperator:
        """Return the operator of varying delay ``number`` with values ``lags`` (n_points,) at ``points``."""
        orders = self.orders[len(self.numeric.model.delays) + number]
        return self.delay.varying_operator(self.mesh, theta, lags, points, number=number, orders=orders)
