"""The equations of a periodic orbit as a list: what stands in which rows, whatever the columns are.

The Jacobian of an orbit (``orbit.jacobian``) and the linearised motion from period to period (``stability.monodromy``)
are made from this one list; they differ in which columns unknowns stand in (``orbit.linearisation``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.residual import Rows, group_by_event, group_by_mode, group_by_reset
from pddecont.orbit.signature import DelayedEventLink

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class FunctionEquations:
    """Equations ``rows`` (n_out, n_points) that hold a factor times ``function`` at equation points ``points``.

    The states there are read from the base points ``base`` (n_points, n_base) with ``weights`` of the same shape. The
    factor is minus the interval's length for a collocation equation (``sign`` 0), else ``sign``.
    """

    function: ArrayFunction
    points: Ints
    rows: Ints
    base: Ints
    weights: Array
    sign: float = 0.0


@dataclass(frozen=True, eq=False)
class SlopeEquations:
    """The slopes of the polynomials in the collocation equations ``rows`` (n_intervals, degree, n_states)."""

    rows: Ints


@dataclass(frozen=True, eq=False)
class StateAfter:
    """The state after the reset at the end of ``segment``, in the equations ``rows`` (n_states,)."""

    rows: Ints
    segment: int


@dataclass(frozen=True, eq=False)
class DelayedEventEquation:
    """The time from a delayed event's source to the event, less its delay if that does not vary."""

    row: int
    link: DelayedEventLink


@dataclass(frozen=True, eq=False)
class PhaseEquation:
    """What fixes where an orbit without events begins."""

    row: int


@dataclass(frozen=True, eq=False)
class PeriodEquation:
    """What fixes when a period of a forced orbit begins."""

    row: int


@dataclass(frozen=True, eq=False)
class TimeEquation:
    """The sum ``coefficients`` (n_theta,) of durations, delays and breaking times."""

    row: int
    coefficients: Array


Equation: TypeAlias = (
    FunctionEquations
    | SlopeEquations
    | StateAfter
    | DelayedEventEquation
    | PhaseEquation
    | PeriodEquation
    | TimeEquation
)


def list_equations(problem: OrbitProblem) -> tuple[Equation, ...]:
    """Return the equations of an orbit, kind by kind; they do not depend on what is read of the past."""
    return problem.mesh.alike(("equations", problem.signature, problem.links), lambda: tuple(_list(problem)))


def _list(problem: OrbitProblem) -> Iterator[Equation]:
    mesh, rows = problem.mesh, Rows(problem.unknowns)
    n, n_segments = problem.numeric.n_states, mesh.n_segments
    collocation = np.arange(rows.n_collocation).reshape(mesh.n_collocation, n)
    yield SlopeEquations(collocation.reshape(mesh.n_intervals, mesh.degree, n))
    for mode, points in group_by_mode(problem):
        interval, node = np.divmod(points, mesh.degree)
        yield FunctionEquations(
            problem.numeric.mode(mode),
            points,
            collocation[points].T,
            mesh.base_index[interval],
            mesh.basis.values[node],
        )
    resets = (rows.resets + np.arange(n_segments * n)).reshape(n_segments, n)
    for s in range(n_segments):
        yield StateAfter(resets[s], s)
    for reset, which in group_by_reset(problem):
        yield _at_ends(problem, problem.numeric.reset(reset), which, resets[which].T, -1.0)
    links = {link.segment: link for link in problem.links}
    for event, which in group_by_event(problem):
        yield _at_ends(problem, problem.numeric.event(event), which, (rows.events + which)[None, :], 1.0)
    for s, segment in enumerate(problem.segments):
        row = rows.events + s
        if s in links:
            yield DelayedEventEquation(row, links[s])
            varying = links[s].find_varying(problem.numeric.model)
            if varying is not None:
                yield _at_ends(problem, problem.numeric.varying_delay(varying), np.array([s]), np.array([[row]]), -1.0)
        elif not segment.event:
            yield PhaseEquation(row)
    yield from _list_breaking(problem, rows)
    yield PeriodEquation(rows.period)


def _list_breaking(problem: OrbitProblem, rows: Rows) -> Iterator[Equation]:
    """Yield the equations of the breaking times, b - source - tau."""
    mesh, n_constant = problem.mesh, len(problem.numeric.model.delays)
    first = mesh.n_collocation + mesh.n_segments
    for j, b in enumerate(mesh.breaking):
        row, own = rows.breaking + j, np.zeros(len(b.source))
        own[len(own) - mesh.n_breaking + j] = 1.0
        yield TimeEquation(row, own - b.source)
        base = mesh.base_index[mesh.breaking_interval[j], -1:][None, :]
        lag = problem.numeric.varying_delay(b.delay - n_constant)
        yield FunctionEquations(lag, np.array([first + j]), np.array([[row]]), base, np.ones((1, 1)), -1.0)


def _at_ends(
    problem: OrbitProblem, function: ArrayFunction, segments: Ints, rows: Ints, sign: float
) -> FunctionEquations:
    """Return ``sign`` times a function at the ends of some segments."""
    mesh = problem.mesh
    base, weights = mesh.last_base[segments][:, None], np.ones((len(segments), 1))
    return FunctionEquations(function, mesh.n_collocation + segments, rows, base, weights, sign)
