"""Newton's method with damping, in variables scaled to order one; its last steps with one Jacobian where that pays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix, ScaledFactors, equilibrate
from pddecont.continuation.system import E, Evaluation
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
# From so many unknowns on a factorisation costs as much as so many steps with an old one, which are taken at most.
LARGE, CHORD_STEPS = 50, 5
LARGER, MORE_CHORD_STEPS = 1000, 10
# The scaled length of a step that is rounding. One of up to so many times this length is rounding too if it is no
# shorter than a tenth of the one before.
EXACT, NOISE = 1e-15, 1000.0
# Solutions with the Jacobian at the end of such steps are corrected to this, relative to their size, so many times.
CORRECTED, MAX_CORRECTIONS = 1e-10, 6


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
    """Where Newton's method arrived; ``history`` holds the scaled residual before each step and at the end.

    ``solve(b)`` solves with the Jacobian at the solution, to within what is left of the last step or ``CORRECTED``.
    ``n_iterations`` counts Newton steps; steps with an old Jacobian count as the Newton steps that they stand for.
    ``factor_anew`` factors the Jacobian at the solution once more; ``factors`` are those of the last step.
    """

    at: E
    history: tuple[float, ...]
    solve: Callable[[Array], Array]
    n_iterations: int
    factor_anew: Callable[[], Callable[[Array], Array]]
    factors: ScaledFactors | None = None

    @property
    def x(self) -> Array:
        """The solution's unknowns."""
        return self.at.x

    def without_factors(self) -> Solution[E]:
        """Return the solution without the factors that it was found with: others are made when they are asked for."""
        factor_anew = cache(self.factor_anew)
        return replace(self, solve=lambda b: factor_anew()(b), factors=None)


@dataclass(frozen=True, eq=False)
class _Step(Generic[E]):
    """A step that was taken: where it led, its scaled length, the scaled residual there, and its factors."""

    at: E
    length: float
    residual: float
    factors: ScaledFactors


def solve_newton(
    evaluate: Callable[[Array], E],
    x: Array,
    scale: Array,
    settings: NewtonSettings | None = None,
    near: ScaledFactors | None = None,
) -> Solution[E]:
    """Return the solution near ``x`` of as many equations as unknowns.

    ``scale`` gives the typical size of each unknown. A step is halved until the scaled residual falls. Where a
    factorisation is expensive and steps with the last one shrink so fast that a few of them lead to the solution, they
    are taken. ``near`` are factors of the Jacobian at another point, which are tried first.

    Raises
    ------
    ConvergenceError
        With the history of residuals, if no solution is reached or the Jacobian is singular.
    """
    settings = settings or NewtonSettings()
    history: list[float] = []
    steps: list[float] = []
    here = evaluate(x)
    if near is not None and (chord := _follow_chord(evaluate, here, near, None, settings)):
        history = [_norm(near.rows * here.residual), *(c.residual for c in chord)]
        return _end_with_chord(chord[-1], history, _count_newton_steps(1.0, chord[0].length, settings), scale)
    for n in range(1, settings.max_iterations + 1):
        step, damping = _take_newton_step(evaluate, here, scale, settings, history)
        here = step.at
        steps.append(step.length)
        if damping == 1.0 and step.length < settings.step_tol and step.residual < settings.residual_tol:
            factors = step.factors
            return Solution(here, tuple(history), factors.solve, n, _find_factors_at(here, scale), factors)
        may_follow = damping == 1.0 and len(scale) >= LARGE
        chord = _follow_chord(evaluate, here, step.factors, step.length, settings) if may_follow else []
        if chord:
            history += [c.residual for c in chord]
            n_iterations = n + _count_newton_steps(step.length, chord[0].length, settings)
            return _end_with_chord(chord[-1], history, n_iterations, scale)
    raise ConvergenceError(
        f"Newton's method did not converge in {settings.max_iterations} iterations "
        f"({_explain_failure(history, steps, settings)})",
        history,
    )


def _take_newton_step(
    evaluate: Callable[[Array], E], here: E, scale: Array, settings: NewtonSettings, history: list[float]
) -> tuple[_Step[E], float]:
    """Return a Newton step and what it was multiplied by; put the scaled residual after it into ``history``."""
    residual = here.residual
    equilibrated = equilibrate(here.jacobian(), scale)
    rows = equilibrated.rows
    size = _norm(rows * residual)
    if not history:
        history.append(size)
    try:
        factors = equilibrated.factor(here.time_order)
        step = factors.solve_scaled(-residual)
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
            history.append(trial_size)
            return _Step(trial, damping * _norm(step), trial_size, factors), damping
        damping *= 0.5
        if damping < settings.min_damping:
            raise ConvergenceError(
                f"Newton's method cannot lower the residual further (residuals: {format_history(history)}){obstacle}",
                history,
            )


def _follow_chord(
    evaluate: Callable[[Array], E], at: E, factors: ScaledFactors, length: float | None, settings: NewtonSettings
) -> list[_Step[E]]:
    """Return the steps with the same factors that lead on to the solution, none if too many would.

    ``length`` is that of the step with these factors that led to ``at``; None for those of another point, whose first
    step says nothing of the next. Each is shorter than the one before by about the same factor, which tells what is
    left after the last.
    """
    result: list[_Step[E]] = []
    most = CHORD_STEPS if len(at.x) < LARGER else MORE_CHORD_STEPS
    while True:
        step = factors.solve_scaled(-at.residual)
        before, length = length, _norm(step)
        shrinks = 1.0 if before is None else length / before
        is_rounding = length <= EXACT or (bool(result) and length <= NOISE * EXACT and shrinks > 0.1)
        if is_rounding or before is None:
            n_left = 1.0
        else:
            n_left = np.log(EXACT / length) / np.log(shrinks) if shrinks < 1.0 else np.inf
        if len(result) + n_left > most:
            return []
        at = evaluate(at.x + factors.columns * step)
        try:
            residual = _norm(factors.rows * at.residual)
        except ConvergenceError:
            return []
        result.append(_Step(at, length, residual, factors))
        arrived = is_rounding or shrinks * length <= EXACT
        if arrived and length < settings.step_tol and residual < settings.residual_tol:
            return result


def _end_with_chord(last: _Step[E], history: list[float], n_iterations: int, scale: Array) -> Solution[E]:
    """Return the solution that steps with one Jacobian have led to."""
    solve, anew = _correct_solutions(last), _find_factors_at(last.at, scale)
    return Solution(last.at, tuple(history), solve, n_iterations, anew, last.factors)


def _count_newton_steps(last: float, first: float, settings: NewtonSettings) -> int:
    """Return how many Newton steps would have followed one of length ``last``, were the next of length ``first``."""
    n, length = 1, first
    while length >= settings.step_tol:
        n, length = n + 1, last * (first / last) ** (2 ** (n + 1) - 1)
    return n


def _find_factors_at(at: Evaluation, scale: Array) -> Callable[[], Callable[[Array], Array]]:
    """Return what factors the Jacobian at a point and returns what solves with it."""
    return lambda: equilibrate(at.jacobian(), scale).factor(at.time_order).solve


def _correct_solutions(last: _Step[E]) -> Callable[[Array], Array]:
    """Return what solves with the Jacobian where a step led, by factors of another not far from it."""
    matrix: list[Matrix] = []

    def solve(b: Array) -> Array:
        matrix.append(matrix.pop() if matrix else last.at.jacobian())
        factors = last.factors
        x = factors.solve(b)
        size = _norm(x / factors.columns) or 1.0
        for _ in range(MAX_CORRECTIONS):
            correction = factors.solve(b - matrix[0] @ x)
            x = x + correction
            if _norm(correction / factors.columns) <= CORRECTED * size:
                return x
        return equilibrate(matrix[0], factors.columns).factor(last.at.time_order).solve(b)

    return solve


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
    largest = float(np.abs(v).max(initial=0.0))
    # What is no number is no smaller than anything.
    return largest if largest < np.inf else np.inf
