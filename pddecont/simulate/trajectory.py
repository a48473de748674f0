"""A trajectory: smooth arcs with dense output, joined by events."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Step:
    """One integration step's continuous extension (DOP853's, degree 7) for the model's states.

    It spans ``t0`` to ``t1`` and is part of the trajectory up to ``end``, which comes before ``t1`` where an event cuts the step.

    Reference: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.6.
    """

    t0: float
    t1: float
    y0: Array
    coefficients: Array
    end: float

    def __call__(self, t: float) -> Array:
        """Return the states at ``t``, shape (n_states,)."""
        s = (t - self.t0) / (self.t1 - self.t0)
        y = np.zeros_like(self.y0)
        for i, f in enumerate(reversed(self.coefficients)):
            y += f
            y *= s if i % 2 == 0 else 1.0 - s
        return y + self.y0


    def component(self, t: float, i: int) -> float:
        """Return state ``i`` at ``t``."""
        s = (t - self.t0) / (self.t1 - self.t0)
        y = 0.0
        for k, f in enumerate(reversed(self.columns[i])):
            y = (y + f) * (s if k % 2 == 0 else 1.0 - s)
        return y + self.columns_y0[i]

    @cached_property
    def columns(self) -> list[list[float]]:
        """The coefficients of each state as plain numbers."""
        return self.coefficients.T.tolist()

    @cached_property
    def columns_y0(self) -> list[float]:
        """The states at the step's start as plain numbers."""
        return self.y0.tolist()


@dataclass(frozen=True, eq=False)
class Happening:
    """An event of a trajectory: the segment that it ended, states just before and just after the reset."""

    t: float
    segment: str
    before: Array
    after: Array


@dataclass(eq=False)
class Arc:
    """The steps between two events, in one mode."""

    mode: str
    steps: list[Step] = field(default_factory=list)

    def __call__(self, t: float) -> Array:
        """Return the states at ``t``; times outside the arc give its ends' polynomials."""
        i = bisect_right(self.steps, t, key=lambda s: s.t0) - 1
        return self.steps[max(i, 0)](t)


@dataclass(eq=False)
class Trajectory:
    """Arcs and the events between them; ``events[i]`` joins ``arcs[i]`` to ``arcs[i + 1]``."""

    t0: float
    arcs: list[Arc]
    events: list[Happening]
    n_steps: int = 0

    @property
    def t_end(self) -> float:
        """Time at which the trajectory ends."""
        return self.arcs[-1].steps[-1].end if self.arcs[-1].steps else self.events[-1].t

    def arc_at(self, t: float) -> Arc:
        """Return the arc that runs at ``t``; at an event the one that begins there."""
        return self.arcs[bisect_right(self.events, t, key=lambda e: e.t)]

    def __call__(self, t: float) -> Array:
        """Return the states at ``t``, shape (n_states,)."""
        return self.arc_at(t)(t)

    def sampled(self, per_step: int = 4) -> tuple[Array, Array, list[str]]:
        """Return times, states (n_times, n_states) and modes, ``per_step`` times in every step, both sides of events."""
        times, states, modes = [], [], []
        for arc in self.arcs:
            for i, step in enumerate(arc.steps):
                first = 0 if i == 0 else 1
                for t in np.linspace(step.t0, step.end, per_step + 1)[first:]:
                    times.append(t)
                    states.append(step(t))
                    modes.append(arc.mode)
        return np.array(times), np.array(states), modes
