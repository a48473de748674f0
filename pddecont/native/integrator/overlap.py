"""Steps that read themselves: lags shorter than a step, lags that vanish, and integrals that begin at the present.

Such a step is implicit. It is repeated with the extension that the last try left, beginning with that of the step
before it continued, until the extension is its own.

Reference: Bellen, Zennaro, Numerical Methods for Delay Differential Equations (2003), section 4.1 (overlapping).
"""

from __future__ import annotations

from math import inf, isfinite

from pddecont.native.integrator.core import Core
from pddecont.native.integrator.dop853 import extend_explicit_step, try_explicit_step
from pddecont.native.integrator.places import HELD, HELD_LENGTH, IN_STEP, MODE, N_COEFFICIENTS, OVERLAPS, UNKNOWN
from pddecont.native.integrator.quadrature import forget_sums
from pddecont.native.integrator.radau import extend_stiff_step, try_stiff_step
from pddecont.native.integrator.rhs import evaluate_rhs

# Repetitions of one step: a contraction by a half leaves 2^-30 of the first error, and slower ones want shorter steps.
MAX_REPETITIONS = 30
# What the last repetition may still change, in errors of the step, or in tolerances where these are less.
REPETITION_TOL = 1e-3
# The error that asks for a step a third to a half as long, whatever the order: there the repetitions converge faster.
NOT_CONVERGED = 1e3


def try_any_step(c: Core, t: float, h: float) -> float:
    """Try a step as :func:`try_explicit_step` or :func:`try_stiff_step` do; one that reads itself is repeated."""
    c.lag_count[HELD], c.lag_count[OVERLAPS], c.lag_count[UNKNOWN] = 0, 0, 0
    forget_sums(c)
    for k in range(c.n_varying):
        c.lag_least[k], c.lag_most[k] = inf, -inf
    error = try_stiff_step(c, t, h) if c.stiff == 1 else try_explicit_step(c, t, h)
    if c.lag_count[OVERLAPS] == 0 or not isfinite(error):
        return error
    last = inf
    _extend_step(c, t, h)
    hold_extension(c, h)
    for repetition in range(MAX_REPETITIONS):
        # What only a try that is repeated reads does not matter.
        c.lag_count[UNKNOWN] = 0
        evaluate_rhs(c, c.count[MODE], t, c.y, c.stages)
        error = try_stiff_step(c, t, h) if c.stiff == 1 else try_explicit_step(c, t, h)
        if not isfinite(error):
            return error
        _extend_step(c, t, h)
        change = _measure_change(c)
        hold_extension(c, h)
        if not isfinite(change):
            return inf
        if change <= REPETITION_TOL * min(1.0, error):
            return error
        # Changes as small as rounding in an extension shrink no further.
        if repetition > 1 and change >= last:
            return error if change <= 1.0 else NOT_CONVERGED
        last = change
    return NOT_CONVERGED


def _extend_step(c: Core, t: float, h: float) -> None:
    if c.stiff == 1:
        extend_stiff_step(c)
    else:
        extend_explicit_step(c, t, h)


def _measure_change(c: Core) -> float:
    """Return how far the extension just made is from the one that is held, relative to the tolerances."""
    n, largest = c.dimension, 0.0
    most = 1e-300
    for i in range(c.n_full, n):
        most = max(most, abs(c.y[i]))
    for i in range(n):
        change = 0.0
        for k in range(N_COEFFICIENTS):
            change += abs(c.extension[k * n + i] - c.held[k * n + i])
        allowed = c.atol + c.rtol * abs(c.y[i]) if i < c.n_full else c.rtol * most
        largest = max(largest, change / allowed)
    return largest


def hold_extension(c: Core, h: float) -> None:
    """Let what reads the present step, of length ``h``, read the extension that it has now."""
    for i in range(N_COEFFICIENTS * c.dimension):
        c.held[i] = c.extension[i]
    c.lag_count[HELD], c.lag_time[HELD_LENGTH] = 1, h


def enter_step(c: Core) -> None:
    """Let lags that vary read the pieces that they read now, all through the step to come."""
    c.lag_count[IN_STEP] = 1


def leave_step(c: Core) -> None:
    """Let what is read come from the steps that are recorded again."""
    c.lag_count[HELD], c.lag_count[IN_STEP] = 0, 0
