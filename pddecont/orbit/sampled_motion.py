"""A periodic motion between the rows of a table: curves that end where states may jump."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator, make_interp_spline

from pddecont.memo import cached_property

Array = NDArray[np.float64]
# A time so near an edge, in periods, is at it.
AT_EDGE = 1e-9
# Rows beyond each end of a curve that closes on itself: its slopes look so far.
OVERLAP = 3


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """A motion that repeats itself, as curves through rows.

    Attributes
    ----------
    edges
        Where the curves begin and the last one ends, a period after the first begins (n_curves + 1,).
    curves
        Functions of time, one between two edges.
    rows
        The times of the rows of each curve.
    closed
        Whether there is one curve that closes on itself: its edges are no moments of a jump.
    """

    edges: Array
    curves: tuple[Any, ...]
    rows: tuple[Array, ...]
    closed: bool

    @cached_property
    def period(self) -> float:
        """The time after which the motion repeats itself."""
        return float(self.edges[-1] - self.edges[0])

    def find_curve(self, t: Array) -> NDArray[np.intp]:
        """Return the numbers of the curves that hold times, on through the periods; at an edge the later one."""
        turns = np.floor((t - self.edges[0]) / self.period).astype(np.intp)
        within = t - turns * self.period
        found = np.clip(np.searchsorted(self.edges, within, side="right") - 1, 0, len(self.curves) - 1)
        return np.asarray(found + turns * len(self.curves))

    def evaluate(self, t: Array, derivative: int = 0, *, curve: NDArray[np.intp] | None = None) -> Array:
        """Return the states at times, or their derivatives, shape (n_times, n_states).

        ``curve`` are the numbers of the curves to read, on through the periods; by default those that hold the times.
        """
        number = self.find_curve(t) if curve is None else curve
        turns, which = np.divmod(number, len(self.curves))
        at = t - turns * self.period
        parts = {int(k): self.curves[k](at[which == k], derivative, extrapolate=True) for k in np.unique(which)}
        result = np.empty((len(t), next(iter(parts.values())).shape[1]))
        for k, values in parts.items():
            result[which == k] = values
        return result

    def evaluate_between(self, t: Array, begin: float, end: float) -> Array:
        """Return the states at times from ``begin`` to ``end``, which see nothing beyond the two."""
        room = AT_EDGE * self.period
        first, last = self.find_curve(np.array([begin + room, end - room]))
        return self.evaluate(t, curve=np.clip(self.find_curve(t), first, max(first, last)))


def join_rows(t: Sequence[Array], x: Sequence[Array], edges: Array) -> SampledMotion:
    """Return the motion of curves between ``edges`` through rows, times (n,) and states (n, n_states) of each."""
    curves = tuple(_fit(*_merge(times, states)) for times, states in zip(t, x, strict=True))
    return SampledMotion(edges, curves, tuple(np.unique(times) for times in t), False)


def close_rows(t: Array, x: Array) -> SampledMotion:
    """Return the motion of one curve through rows, the last of which is the first again, a period later."""
    t, x = _merge(t, x)
    period, x = t[-1] - t[0], x.copy()
    x[0] = x[-1] = 0.5 * (x[0] + x[-1])
    n = min(OVERLAP, len(t) - 2)
    times = np.concatenate([t[-1 - n : -1] - period, t, t[1 : 1 + n] + period])
    states = np.concatenate([x[-1 - n : -1], x, x[1 : 1 + n]])
    return SampledMotion(np.array([t[0], t[-1]]), (_fit(times, states),), (t,), True)


def _merge(t: Array, x: Array) -> tuple[Array, Array]:
    """Return rows with those at one time, which few digits made of several, put together."""
    times, where, counts = np.unique(t, return_inverse=True, return_counts=True)
    states = np.zeros((len(times), x.shape[1]))
    np.add.at(states, where, x)
    return times, states / counts[:, None]


def _fit(t: Array, x: Array) -> Any:
    """Return the curve through two rows or more, whose slopes see their neighbours alone: corners stay where they are.

    References
    ----------
    H. Akima, A new method of interpolation and smooth curve fitting based on local procedures, J. ACM 17 (1970)
    589-602, doi:10.1145/321607.321609.
    """
    return make_interp_spline(t, x, k=1) if len(t) == 2 else Akima1DInterpolator(t, x, method="makima")
