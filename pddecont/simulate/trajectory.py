"""A trajectory: the steps of an integration with their continuous extensions, and the events between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# Times a whole number of intervals after another are found whatever rounding made of them.
ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class Events:
    """Events of a trajectory in order.

    Attributes
    ----------
    t, segment
        When they happen (n_events,), and the names of the segments that they end.
    before, after
        States before and after the reset (n_events, n_states).
    arc
        The arc that each begins (n_events,).
    """

    t: Array
    segment: tuple[str, ...]
    before: Array
    after: Array
    arc: Integers

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Steps of an integration and the events between them.

    Attributes
    ----------
    time, length, end
        Where a step begins, how long it is, and up to where it belongs to the trajectory: sooner than its end where an
        event cuts it (n_steps,).
    arc, mode
        The arc that a step belongs to, counted by events, and the mode of that arc (n_steps,).
    value, coefficients
        The continuous extensions (n_steps, n_states), (n_steps, 7, n_states).
    events
        The events.
    n_steps
        How many steps were made, those that were not kept too.
    rtol, atol
        The errors allowed in a step, relative and absolute.

    References
    ----------
    Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.6.
    """

    time: Array
    length: Array
    end: Array
    arc: Integers
    mode: tuple[str, ...]
    value: Array
    coefficients: Array
    events: Events
    n_steps: int
    rtol: float = 0.0
    atol: float = 0.0

    @property
    def t0(self) -> float:
        """Time at which what is kept begins."""
        return float(self.time[0])

    @property
    def t_end(self) -> float:
        """Time at which the trajectory ends."""
        return float(self.end[-1])

    def __call__(self, t: float | Array) -> Array:
        """Return the states at ``t``, shape (n_states,) or (n_times, n_states); at an event those after it."""
        times = np.atleast_1d(np.asarray(t, dtype=float))
        found = self.evaluate_steps(
            times, np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, len(self.time) - 1)
        )
        if len(self.events) and self.events.t[-1] >= self.t_end:
            found[times >= self.t_end] = self.events.after[-1]
        return found if np.ndim(t) else found[0]

    def evaluate_arc(self, arc: int, t: Array) -> Array:
        """Return the states at times ``t`` in an arc, shape (n_times, n_states).

        Times outside the arc read the polynomials at its ends.
        """
        first, last = np.searchsorted(self.arc, arc), np.searchsorted(self.arc, arc, side="right")
        if first == last:
            # Between two events at one moment there is an arc of no length.
            return np.repeat(self.events.after[self.events.arc == arc][:1], len(t), axis=0)
        return self.evaluate_steps(
            t, np.clip(first + np.searchsorted(self.time[first:last], t, side="right") - 1, first, last - 1)
        )

    def find_mode(self, arc: int) -> str:
        """Return the mode of an arc."""
        return self.mode[min(int(np.searchsorted(self.arc, arc)), len(self.mode) - 1)]

    def evaluate_steps(self, t: Array, step: NDArray[np.intp]) -> Array:
        """Return the continuous extensions of steps, one a time, at times ``t``, shape (n_times, n_states)."""
        s = ((t - self.time[step]) / self.length[step])[:, None]
        y = np.zeros((len(t), self.value.shape[1]))
        for i in range(self.coefficients.shape[1] - 1, -1, -1):
            y = (y + self.coefficients[step, i]) * (s if i % 2 == 0 else 1.0 - s)
        return y + self.value[step]

    def differentiate(self, t: Array, order: int) -> Array:
        """Return the states at times ``t``, or their derivatives of an order, shape (n_times, n_states)."""
        if order == 0:
            return self(t)
        step = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, len(self.time) - 1)
        s = ((t - self.time[step]) / self.length[step])[:, None]
        # Derivatives of the same recursion as above, by the product rule.
        found = [np.zeros((len(t), self.value.shape[1])) for _ in range(order + 1)]
        for i in range(self.coefficients.shape[1] - 1, -1, -1):
            factor, slope = (s, 1.0) if i % 2 == 0 else (1.0 - s, -1.0)
            found[0] = found[0] + self.coefficients[step, i]
            for k in range(order, 0, -1):
                found[k] = found[k] * factor + k * slope * found[k - 1]
            found[0] = found[0] * factor
        return np.asarray(found[order] / self.length[step][:, None] ** order)

    def sample(self, per_step: int = 4) -> tuple[Array, Array, list[str]]:
        """Return times, states (n_times, n_states) and modes, ``per_step`` times in every step.

        An event has two rows: the states before and after it.
        """
        shares = np.arange(per_step + 1) / per_step
        times = self.time[:, None] + shares * (self.end - self.time)[:, None]
        times[:, -1] = self.end
        steps = np.repeat(np.arange(len(self.time))[:, None], per_step + 1, axis=1)
        shown = np.ones(times.shape, dtype=bool)
        shown[1:, 0] = self.arc[1:] != self.arc[:-1]
        times, steps = times[shown], steps[shown]
        return times, self.evaluate_steps(times, steps), [self.mode[i] for i in steps]

    def sample_every(self, interval: float, t_from: float) -> tuple[Array, Array, list[str]]:
        """Return times from ``t_from`` on that are ``interval`` apart, states (n_times, n_states) and modes."""
        times = np.asarray(
            t_from + interval * np.arange(int((self.t_end - t_from) / interval * (1 + ROUNDING)) + 1), dtype=np.float64
        )
        steps = np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, len(self.time) - 1)
        return times, self.evaluate_steps(times, steps), [self.mode[i] for i in steps]
