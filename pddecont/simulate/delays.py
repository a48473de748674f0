"""Where an integration finds delayed values: in the past, or at the end of the paper's chain."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.chain import Chain
from pddecont.model.codegen import NumericModel
from pddecont.model.expression import TIME
from pddecont.model.system import symbol
from pddecont.simulate.trajectory import Step

Array = NDArray[np.float64]
History = Callable[[float], Sequence[float]]


class Delays(Protocol):
    """How delayed values enter the ordinary differential equations that are integrated."""

    n_extra: int
    max_step: float

    def start(self, t: float) -> Array:
        """Return the extra variables at the start."""
        ...

    def values(self, t: float, y: Array) -> list[float]:
        """Return the delayed values at ``t`` for states and extra variables ``y``."""
        ...

    def slopes(self, y: Array) -> Array:
        """Return the derivatives of the extra variables."""
        ...

    def record(self, step: Step) -> None:
        """Take note of a finished step."""
        ...

    def new_arc(self, t: float) -> None:
        """Hear that an arc begins."""
        ...

    def begin(self, t: float) -> None:
        """Hear that steps begin at ``t``."""
        ...


@dataclass(eq=False)
class Past:
    """Delayed values from the trajectory's own arcs.

    Steps between two stops read each delay from one arc, chosen when they begin: at a jump that is the side which the steps come from.
    """

    pairs: tuple[tuple[int, int], ...]
    tau: Array
    history: History
    t0: float

    def __post_init__(self) -> None:
        self.starts: list[float] = []
        self.arcs: list[list[Step]] = []
        self.n_extra = 0
        self.max_step = min((tau for tau in self.tau if tau > 0), default=math.inf)
        self.reading = [-1] * len(self.tau)

    def start(self, t: float) -> Array:
        """Return the extra variables at the start."""
        return np.zeros(0)

    def new_arc(self, t: float) -> None:
        """Hear that an arc begins."""
        self.starts.append(t)
        self.arcs.append([])

    def begin(self, t: float) -> None:
        """Choose the arcs that steps from ``t`` on read."""
        self.reading = [bisect_right(self.starts, t - tau + 1e-11 * (1.0 + abs(t))) - 1 for tau in self.tau]

    def values(self, t: float, y: Array) -> list[float]:
        """Return the delayed values at ``t``."""
        return [float(y[state]) if self.tau[k] == 0.0 else self._read(t - self.tau[k], state, self.reading[k]) for state, k in self.pairs]

    def _read(self, t: float, state: int, arc: int) -> float:
        if arc < 0:
            return float(self.history(t)[state])
        steps = self.arcs[arc]
        while not steps and arc > 0:
            arc -= 1
            steps = self.arcs[arc]
        if not steps:
            return float(self.history(t)[state])
        i = bisect_right(steps, t, key=lambda s: s.t0) - 1
        return steps[max(i, 0)].component(t, state)

    def slopes(self, y: Array) -> Array:
        """Return the derivatives of the extra variables."""
        return np.zeros(0)

    def record(self, step: Step) -> None:
        """Take note of a finished step."""
        self.arcs[-1].append(step)


@dataclass(eq=False)
class ChainStates:
    """Delayed values from the explicit states of the chain, eqs. (2.4)-(2.7): w_k of every stage, scaled by delta^k."""

    chain: Chain
    pairs: tuple[tuple[int, int], ...]
    tau: Array
    derivatives: Sequence[History]
    t0: float

    def __post_init__(self) -> None:
        self.max_step = math.inf
        self.active = [i for i, (_, k) in enumerate(self.pairs) if self.tau[k] > 0]
        self.delta = np.array([self.tau[self.pairs[i][1]] for i in self.active]) / self.chain.n
        self.shape = (len(self.active), self.chain.n, self.chain.order)
        self.n_extra = math.prod(self.shape)
        self.states = [self.pairs[i][0] for i in self.active]
        self.inverse_factorial = np.array([1.0 / math.factorial(k) for k in range(self.chain.order)])
        self.top = math.factorial(self.chain.order)

    def start(self, t: float) -> Array:
        """Return the extra variables at the start."""
        w = np.empty(self.shape)
        for row, (state, delta) in enumerate(zip(self.states, self.delta, strict=True)):
            for i in range(self.chain.n):
                for k in range(self.chain.order):
                    w[row, i, k] = self.derivatives[k](t - (i + 1) * delta)[state] * delta**k
        return w.ravel()

    def values(self, t: float, y: Array) -> list[float]:
        """Return the delayed values at ``t``."""
        result = [float(y[state]) for state, _ in self.pairs]
        last = y[len(y) - self.n_extra :].reshape(self.shape)[:, -1, 0]
        for row, i in enumerate(self.active):
            result[i] = float(last[row])
        return result

    def slopes(self, y: Array) -> Array:
        """Return the derivatives of the extra variables."""
        w = y[len(y) - self.n_extra :].reshape(self.shape)
        slope = np.empty_like(w)
        slope[:, :, :-1] = w[:, :, 1:]
        before = np.concatenate([y[self.states][:, None], w[:, :-1, 0]], axis=1)
        slope[:, :, -1] = self.top * (before - w @ self.inverse_factorial)
        return (slope / self.delta[:, None, None]).ravel()

    def record(self, step: Step) -> None:
        """Take note of a finished step."""

    def new_arc(self, t: float) -> None:
        """Hear that an arc begins."""

    def begin(self, t: float) -> None:
        """Hear that steps begin at ``t``."""


def history_functions(numeric: NumericModel, p: Array, n_derivatives: int) -> list[History]:
    """Return the initial history and its first derivatives as functions of time."""
    model = numeric.model
    values = {symbol(name): value for name, value in zip(model.parameters, p, strict=True)}
    functions = []
    for k in range(n_derivatives + 1):
        exprs = [e.diff(TIME, k).subs(values) if k else e.subs(values) for e in model.history]
        functions.append(_plain(numeric, exprs, p))
    return functions


def _plain(numeric: NumericModel, exprs: Sequence[Any], p: Array) -> History:
    scalar = numeric.function(exprs).scalar
    parameters = p.tolist()

    def history(t: float) -> Sequence[float]:
        out = [0.0] * len(exprs)
        scalar(t, [], [], parameters, out)
        return out

    return history
