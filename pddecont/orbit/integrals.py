"""Integrals over the past of an orbit, by Gauss quadrature over the pieces of its mesh.

The integral of g(s, x(t - s)) over lags s from a to b is a sum over the mesh intervals that lie between t - b and
t - a, the first and the last of them cut there. On each the orbit is one polynomial, so that the quadrature converges
as the orbit does. Where u = t - s in interval j at sigma, everything moves with theta:

    V = sum_r w_r (beta - alpha) g(s_r, x(sigma_r)),  u_r = alpha + (beta - alpha) xi_r,  s_r = t - u_r

with alpha the larger of the interval's start and t - b, beta the smaller of its end and t - a. How a and b themselves
depend on states is the business of the chain rule (``model.lagged``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction, Derivatives
from pddecont.collocation import Mesh, MeshPoints
from pddecont.delay import LocalWeights
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Gauss points in a mesh interval beyond its polynomials' degree.
MORE_NODES = 2


@dataclass(frozen=True, eq=False)
class Window:
    """The parts of the past that points integrate over: P pairs of a point and a mesh interval.

    ``point`` (P,) numbers the points, ``interval`` and ``wraps`` (P,) say what is read and how many periods back;
    ``low`` and ``high`` (P,) are the times between which, from the orbit's start; ``cut_low`` and ``cut_high`` (P,)
    whether those are a limit's, not the interval's own.
    """

    point: Ints
    interval: Ints
    wraps: Ints
    low: Array
    high: Array
    cut_low: NDArray[np.bool_]
    cut_high: NDArray[np.bool_]


def find_window(mesh: Mesh, theta: Array, times: Array, low: Array, high: Array) -> Window:
    """Return the parts of the past from ``high`` to ``low`` before the ``times``; all of shape (n_points,).

    Raises
    ------
    ConvergenceError
        If an integral would read the future.
    """
    if not np.all((low >= 0.0) & (high >= low)):
        raise ConvergenceError("an integral over the past ends before it begins, or reads the future")
    period, (starts, lengths) = mesh.period(theta), mesh.evaluate_edges(theta)
    begin, end = times - high, times - low
    turns = np.arange(np.floor(np.min(begin) / period), np.floor(np.max(end) / period) + 1.0)
    edges = (starts + period * turns[:, None]).ravel()
    first = np.clip(np.searchsorted(edges, begin, side="right") - 1, 0, len(edges) - 1)
    last = np.clip(np.searchsorted(edges, end, side="left"), first + 1, len(edges))
    count = last - first
    point = np.repeat(np.arange(len(times)), count)
    place = np.arange(len(point)) - np.repeat(np.cumsum(count) - count, count) + first[point]
    interval, wraps = place % mesh.n_intervals, -turns[place // mesh.n_intervals].astype(np.intp)
    own = edges[place]
    own_end = own + lengths[interval]
    return Window(
        point,
        interval,
        wraps,
        np.maximum(own, begin[point]),
        np.minimum(own_end, end[point]),
        begin[point] > own,
        end[point] < own_end,
    )


@dataclass(frozen=True, eq=False)
class IntegralOperator:
    """One integral over the past at some points of an orbit.

    ``value`` (n_points,); ``pairs`` says which base points each pair of ``window`` reads; ``state_weights`` (P, degree
    + 1) by state are the derivatives of the pairs' parts of the integral in those. What times make of it is kept for
    :meth:`moves`: nodes ``xi`` and weights (n_nodes,), values, slopes in s and in sigma at the nodes (P, n_nodes).
    """

    window: Window
    pairs: LocalWeights
    value: Array
    state_weights: Mapping[int, Array]
    xi: Array
    quadrature: Array
    integrand: Array
    slope: Array
    stretch: Array

    @property
    def weights(self) -> LocalWeights:
        """What the pairs read."""
        return self.pairs

    def reads_as(self, other: IntegralOperator) -> bool:
        """Return whether every point reads the same base points, as many periods back, as with ``other``."""
        return np.array_equal(self.window.point, other.window.point) and self.pairs.reads_as(other.pairs)

    def moves(self, times: Array, starts: Array, lengths: Array, read: Ints, h: Array) -> Array:
        """Return how the integral moves with components of theta, base values fixed, shape (n_points, c).

        Each pair's part moves with the time of its point and with start and length of what it reads, by numbers that
        the quadrature gives: one sparse product a kind.

        Parameters
        ----------
        times
            How the points move (n_points, c).
        starts, lengths
            How the starts and lengths of intervals move, in the turns that they are read in (n_read, c).
        read
            Which of those each pair reads (P,).
        h
            Lengths of the pairs' intervals (P,).
        """
        w, sigma = self.window, self.pairs.sigma
        width = w.high - w.low
        # Where u = low + xi (high - low): the derivatives in u, and those with its place among low and high.
        by_lag, by_sigma = self.slope * width[:, None], self.stretch * (width / h)[:, None]
        in_place = by_sigma - by_lag
        part = self.integrand @ self.quadrature
        by_high = part + in_place @ (self.quadrature * self.xi)
        by_low = in_place @ (self.quadrature * (1.0 - self.xi)) - part
        by_start = np.where(w.cut_low, 0.0, by_low) + np.where(w.cut_high, 0.0, by_high) - by_sigma @ self.quadrature
        by_length = np.where(w.cut_high, 0.0, by_high) - (by_sigma * sigma) @ self.quadrature
        here = np.where(w.cut_low, by_low, 0.0) + np.where(w.cut_high, by_high, 0.0) + by_lag @ self.quadrature
        n = len(self.value)
        total: Array = np.bincount(w.point, here, n)[:, None] * times
        for values, moving in ((by_start, starts), (by_length, lengths)):
            total += sp.csr_array((values, (w.point, read)), shape=(n, len(moving))) @ moving
        return total


def make_integral_operator(
    integrand: ArrayFunction, mesh: Mesh, theta: Array, values: Array, points: MeshPoints, limits: Array, p: Array
) -> IntegralOperator:
    """Return an integral at ``points`` of the orbit with base ``values``; ``limits`` (2, n_points) low and high."""
    times, (starts, lengths) = mesh.evaluate_times(points, theta), mesh.evaluate_edges(theta)
    window = find_window(mesh, theta, times, *limits)
    xi, quadrature = _make_quadrature(mesh.degree + MORE_NODES)
    h, width = lengths[window.interval], window.high - window.low
    start = starts[window.interval] - window.wraps * mesh.period(theta)
    at = window.low[:, None] + xi * width[:, None]
    nodes = _find_nodes(mesh, window, xi, (at - start[:, None]) / h[:, None])
    x, lags = nodes.interpolate(mesh, values), times[window.point][:, None] - at
    d = _evaluate(integrand, lags, x, p)
    where = integrand.structure()
    g = d.value[0].reshape(lags.shape)
    slope, stretch = np.zeros(lags.shape), np.zeros(lags.shape)
    if len(where.dt):
        slope = d.dt[0].reshape(lags.shape)
    state_weights: dict[int, Array] = {}
    scale = quadrature * width[:, None]
    for state, slopes in zip(where.dx[1].tolist(), d.dx, strict=True):
        by_node = slopes.reshape(lags.shape)
        stretch += by_node * nodes.interpolate(mesh, values[:, [state]], derivative=True)[0]
        state_weights[state] = nodes.collect(scale * by_node)
    value = np.asarray(np.bincount(window.point, np.sum(scale * g, axis=1), len(points)), dtype=np.float64)
    pairs = LocalWeights(nodes.columns, nodes.list_first(), window.interval, nodes.sigma, window.wraps)
    return IntegralOperator(window, pairs, value, state_weights, xi, quadrature, g, slope, stretch)


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Where pairs are read: ``sigma`` (P, n_nodes) in intervals with base points ``columns`` (P, degree + 1).

    Most pairs are whole intervals, and read as these do: ``whole`` (n_nodes, degree + 1) are the weights of base values
    there, ``own`` (n, n_nodes, degree + 1) those of the pairs ``cut`` (n,) by a limit.
    """

    interval: Ints
    columns: Ints
    sigma: Array
    whole: Array
    cut: Ints
    own: Array

    def interpolate(self, mesh: Mesh, values: Array, *, derivative: bool = False) -> Array:
        """Return base ``values`` (n_base, n), or their derivatives in sigma, at the nodes, shape (n, P, n_nodes)."""
        matrix = mesh.basis.differentiate if derivative else np.eye(mesh.degree + 1)
        every = np.einsum("rb,jbn->njr", self.whole @ matrix, values[mesh.base_index])
        result: Array = every[:, self.interval]
        result[:, self.cut] = np.einsum("prb,pbn->npr", self.own @ matrix, values[self.columns[self.cut]])
        return result

    def collect(self, numbers: Array) -> Array:
        """Return what ``numbers`` (P, n_nodes) at the nodes are as weights of base values, shape (P, degree + 1)."""
        result: Array = numbers @ self.whole
        result[self.cut] = np.einsum("pr,prb->pb", numbers[self.cut], self.own)
        return result

    def list_first(self) -> Array:
        """Return the weights of base values at the first node of each pair, shape (P, degree + 1)."""
        result = np.tile(self.whole[0], (len(self.sigma), 1))
        result[self.cut] = self.own[:, 0]
        return result


def _find_nodes(mesh: Mesh, window: Window, xi: Array, sigma: Array) -> _Nodes:
    cut = np.flatnonzero(window.cut_low | window.cut_high)
    own = mesh.basis.lagrange(sigma[cut])
    columns = mesh.base_index[window.interval]
    return _Nodes(window.interval, columns, sigma, mesh.basis.lagrange(xi), cut, own)


@cache
def _make_quadrature(n: int) -> tuple[Array, Array]:
    """Return the nodes and weights of Gauss quadrature with ``n`` points on [0, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return 0.5 * (nodes + 1.0), 0.5 * weights


def _evaluate(integrand: ArrayFunction, lags: Array, x: Array, p: Array) -> Derivatives:
    """Return an integrand with its derivatives at lags (P, n_nodes) and states (n_states, P, n_nodes)."""
    nothing = np.zeros((len(integrand.delayed), lags.size))
    return integrand.derivatives(lags.ravel(), x.reshape(len(x), -1), nothing, p)
