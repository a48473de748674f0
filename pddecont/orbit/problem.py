"""What a periodic orbit must satisfy: model, signature, mesh, delay method, free parameters."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.operator import DelayMethod, DelayOperator
from pddecont.model.codegen import NumericModel
from pddecont.model.system import IDENTITY, Segment
from pddecont.orbit.layout import Layout
from pddecont.orbit.mesh import Mesh, Places

Array = NDArray[np.float64]
# A segment shorter than this many periods has no duration: rounding decides on its sign.
INSTANT = 1e-12


def eventless(mode: str) -> Segment:
    """Return the only segment of an orbit that meets no event in ``mode``."""
    return Segment(f"({mode})", mode, "", "any", IDENTITY, mode)


@dataclass(frozen=True, eq=False)
class OrbitProblem:
    """The boundary-value problem of design section 5 for one signature on one mesh.

    ``segments`` is the signature; an orbit without events is one segment that leads to itself (:func:`eventless`).

    ``parameters`` holds all parameter values, of which those named in ``free`` are replaced by unknowns. ``n_periods`` is k
    in sum T_s = k * forcing period. ``reference`` fixes the phase of an orbit without events: base values z_ref (n_base,
    n_states) with integral z . z_ref' = 0 for an autonomous model; a forced one starts at t_0 = ``phase``.
    ``timers`` says for each segment that ends by a delayed event which segment's end started it and how many periods before.
    """

    numeric: NumericModel
    segments: tuple[Segment, ...]
    mesh: Mesh
    delay: DelayMethod
    parameters: Array
    free: tuple[str, ...] = ()
    n_periods: int = 1
    reference: Array | None = None
    phase: float = 0.0
    timers: tuple[tuple[int, int, int], ...] = ()

    @cached_property
    def layout(self) -> Layout:
        """Places of the unknowns."""
        return Layout(self.mesh, self.numeric.n_states, self.numeric.model.forced, len(self.free))

    @cached_property
    def free_index(self) -> tuple[int, ...]:
        """Places of the free parameters among all parameters."""
        return tuple(map(self.numeric.parameter_index, self.free))

    def all_parameters(self, x: Array) -> Array:
        """Return all parameter values at the unknowns ``x``."""
        p = self.parameters.copy()
        p[list(self.free_index)] = x[self.layout.free]
        return p

    def theta(self, x: Array) -> Array:
        """Return theta = (T_1..T_S, tau_1..tau_K) at the unknowns ``x``."""
        return np.concatenate([x[self.layout.durations], self.numeric.delays.value(self.all_parameters(x))])

    def period(self, x: Array) -> float:
        """Return the orbit's period, the sum of its segment durations."""
        return float(np.sum(x[self.layout.durations]))

    def operators(self, theta: Array, places: Places) -> list[DelayOperator]:
        """Return one operator a delay at ``theta`` for reads at ``places``."""
        first = self.mesh.n_segments
        return [self.delay.operator(self.mesh, theta, first + k, places) for k in range(len(theta) - first)]

    @cached_property
    def _found(self) -> deque[tuple[Array, dict[str, Any]]]:
        return deque(maxlen=8)

    def once(self, what: str, x: Array, find: Callable[[], Any]) -> Any:
        """Return ``what`` of the orbit ``x``, found once while that orbit is in use."""
        known = next((found for at, found in self._found if at is x), None)
        if known is None:
            known = {}
            self._found.append((x, known))
        if what not in known:
            known[what] = find()
        return known[what]

    def with_free(self, x: Array, free: tuple[str, ...]) -> tuple[OrbitProblem, Array]:
        """Return the same problem and orbit with other free parameters."""
        parameters = self.all_parameters(x)
        problem = replace(self, parameters=parameters, free=free)
        values, durations, start, _ = self.layout.split(x)
        return problem, problem.layout.join(values, durations, start, parameters[list(problem.free_index)])


@dataclass(frozen=True, eq=False)
class Reads:
    """States and delayed values of an orbit at some places of its mesh.

    Shapes: values (n_base, n_states), theta (S + K,), h (n_intervals,), t (n_places,) physical time, x (n_states, n_places),
    xd (n_delayed, n_places), p (n_parameters,).
    """

    values: Array
    start: float
    p: Array
    theta: Array
    h: Array
    t: Array
    x: Array
    xd: Array
    operators: list[DelayOperator]


def read(problem: OrbitProblem, x: Array, places: Places, *, delays: bool = True) -> Reads:
    """Return what the orbit with unknowns ``x`` is at ``places``, delays read by the problem's method.

    ``delays=False`` leaves the delayed values at zero, for functions that do not use them.
    """
    mesh = problem.mesh
    values, _, start, _ = problem.layout.split(x)
    theta = problem.theta(x)
    operators = problem.operators(theta, places) if delays else []
    delayed = problem.numeric.model.delayed
    xd = np.zeros((len(delayed), len(places)))
    for k, operator in enumerate(operators):
        rows = [i for i, (_, delay) in enumerate(delayed) if delay == k]
        states = [delayed[i][0] for i in rows]
        xd[rows] = operator.weights.apply(values[:, states]).T
    t = start + mesh.times(places) @ theta
    return Reads(values, start, problem.all_parameters(x), theta, mesh.length @ theta, t, mesh.at(values, places).T, xd, operators)
