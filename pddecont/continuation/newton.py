"""Newton's method with damping, in variables scaled to order one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.linear import equilibrate
from pddecont.continuation.system import E
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
class Solution(Generic[E]):
    """Where Newton's method arrived; ``history`` holds the scaled residual before each iteration and at the end.

    ``solve(b)`` solves with the last Jacobian, which is that at the solution to within the last step.
    """

    at: E
    history: tuple[float, ...]
    solve: Callable[[Array], Array]

    @property
    def x(self) -> Array:
        """The solution's unknowns."""
        return self.at.x

    @property
    def n_iterations(self) -> int:
        """Number of Newton steps taken."""
        return len(self.history) - 1


def solve_newton(
    evaluate: Callable[[Array], E], x: Array, scale: Array, settings: NewtonSettings | None = None
) -> Solution[E]:
    """Return the solution near ``x`` of as many equations as unknowns.

    ``scale`` gives the typical size of each unknown. A step is halved until the scaled residual falls.

    Raises
    ------
    ConvergenceError
        With the history of residuals, if no solution is reached or the Jacobian is singular.
    """
    settings = settings or NewtonSettings()
    history: list[float] = []
    steps: list[float] = []
    here = evaluate(x)
    r = here.residual
    for _ in range(settings.max_iterations):
        equilibrated = equilibrate(here.jacobian(), scale)
        rows = equilibrated.rows
        size = _norm(rows * r)
        if not history:
            history.append(size)
        try:
            factors = equilibrated.factor()
            step = factors.solve_scaled(-r)
        except ConvergenceError as exc:
            raise ConvergenceError(f"{exc} (residuals: {format_history(history)})", history) from exc
        damping, obstacle = 1.0, ""
        while True:
            trial = evaluate(here.x + damping * scale * step)
            try:
                trial_size = _norm(rows * trial.residual)
            except ConvergenceError as exc:
                trial_size, obstacle = np.inf, f"; {exc}"
            if trial_size < size or trial_size < settings.residual_tol:
                break
            damping *= 0.5
            if damping < settings.min_damping:
                raise ConvergenceError(
                    f"Newton's method cannot lower the residual further (residuals: {format_history(history)})"
                    f"{obstacle}",
                    history,
                )
        here, r = trial, trial.residual
        history.append(trial_size)
        steps.append(damping * _norm(step))
        if damping == 1.0 and steps[-1] < settings.step_tol and trial_size < settings.residual_tol:
            return Solution(here, tuple(history), factors.solve)
    raise ConvergenceError(
        f"Newton's method did not converge in {settings.max_iterations} iterations "
        f"({_explain_failure(history, steps, settings)})",
        history,
    )


def _explain_failure(history: list[float], steps: list[float], settings: NewtonSettings) -> str:
    """Return what kept the method going: residuals, or steps that stay large where the equations hold already."""
    if history[-1] < settings.residual_tol:
        return (
            f"the equations hold to {history[-1]:.1e}, but the unknowns still move: the last steps are "
            f"{format_history(steps[-3:])}, expected below {settings.step_tol:.0e}; the solution is not unique here, "
            "or nearly so"
        )
    return f"residuals: {format_history(history)}"


def format_history(history: Sequence[float]) -> str:
    """Return residual norms for a message."""
    return ", ".join(f"{value:.1e}" for value in history) or "none"


def _norm(v: Array) -> float:
    largest = float(np.max(np.abs(v), initial=0.0))
    return largest if np.isfinite(largest) else np.inf
