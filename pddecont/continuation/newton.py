"""Newton's method with damping, in variables scaled to order one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.linear import Factors, Matrix, factor, row_maxima, scale_matrix
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NewtonSettings:
    """When Newton's method stops.

    ``step_tol`` bounds the largest scaled component of the last step: convergence is quadratic, so the error left is
    about its square. ``residual_tol`` bounds the residual with rows scaled by their largest entry of the Jacobian.
    """

    step_tol: float = 1e-8
    residual_tol: float = 1e-9
    max_iterations: int = 12
    min_damping: float = 1.0 / 64.0


@dataclass(frozen=True, eq=False)
class Solution:
    """Where Newton's method arrived; ``history`` holds the scaled residual before each iteration and at the end.

    ``solve(b)`` solves with the last Jacobian, which is that at ``x`` to within the last step.
    """

    x: Array
    history: tuple[float, ...]
    solve: Callable[[Array], Array]

    @property
    def n_iterations(self) -> int:
        """Number of Newton steps taken."""
        return len(self.history) - 1


def newton(residual: Callable[[Array], Array], jacobian: Callable[[Array], Matrix], x: Array, scale: Array,
           settings: NewtonSettings | None = None) -> Solution:  # fmt: skip
    """Return the solution of ``residual(x) = 0`` near ``x``.

    ``scale`` gives the typical size of each unknown. A step is halved until the scaled residual falls.

    Raises
    ------
    ConvergenceError
        With the history of residuals, if no solution is reached or the Jacobian is singular.
    """
    settings = settings or NewtonSettings()
    history: list[float] = []
    steps: list[float] = []
    r = residual(x)
    for _ in range(settings.max_iterations):
        matrix = scale_matrix(jacobian(x), np.ones(len(r)), scale)
        rows = 1.0 / row_maxima(matrix)
        size = _norm(rows * r)
        if not history:
            history.append(size)
        try:
            factors = factor(scale_matrix(matrix, rows, np.ones(len(x))))
            step = factors.solve(-rows * r)
        except ConvergenceError as exc:
            raise ConvergenceError(f"{exc} (residuals: {show(history)})", history) from exc
        damping, obstacle = 1.0, ""
        while True:
            trial = x + damping * scale * step
            try:
                r_trial = residual(trial)
                trial_size = _norm(rows * r_trial)
            except ConvergenceError as exc:
                trial_size, obstacle = np.inf, f"; {exc}"
            if trial_size < size or trial_size < settings.residual_tol:
                break
            damping *= 0.5
            if damping < settings.min_damping:
                raise ConvergenceError(f"Newton's method cannot lower the residual further (residuals: {show(history)}){obstacle}", history)
        x, r = trial, r_trial
        history.append(trial_size)
        steps.append(damping * _norm(step))
        if damping == 1.0 and steps[-1] < settings.step_tol and trial_size < settings.residual_tol:
            return Solution(x, tuple(history), partial(_solve, factors, rows, scale))
    raise ConvergenceError(f"Newton's method did not converge in {settings.max_iterations} iterations "
                           f"({_unmet(history, steps, settings)})", history)  # fmt: skip


def _unmet(history: list[float], steps: list[float], settings: NewtonSettings) -> str:
    """Return in words what kept the method going: residuals, or steps that stay large where the equations hold already."""
    if history[-1] < settings.residual_tol:
        return (f"the equations hold to {history[-1]:.1e}, but the unknowns still move: the last steps are {show(steps[-3:])}, expected "
                f"below {settings.step_tol:.0e}; the solution is not unique here, or nearly so")  # fmt: skip
    return f"residuals: {show(history)}"


def _solve(factors: Factors, rows: Array, scale: Array, b: Array) -> Array:
    return scale * factors.solve(rows * b)


def show(history: list[float]) -> str:
    """Return residual norms for a message."""
    return ", ".join(f"{value:.1e}" for value in history) or "none"


def _norm(v: Array) -> float:
    largest = float(np.max(np.abs(v), initial=0.0))
    return largest if np.isfinite(largest) else np.inf
