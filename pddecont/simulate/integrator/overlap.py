"""Steps that read themselves: lags shorter than a step, lags that vanish, and integrals that begin at the present.

Such a step is implicit. It is repeated with the extension that the last try left, beginning with that of the step
before it continued, until the extension is its own.

Reference: Bellen, Zennaro, Numerical Methods for Delay Differential Equations (2003), section 4.1 (overlapping).
"""

from __future__ import annotations

import math

from pddecont.simulate.integrator.buffers import N_COEFFICIENTS
from pddecont.simulate.integrator.calls import internal
from pddecont.simulate.integrator.dop853 import extend_explicit_step, try_explicit_step
from pddecont.simulate.integrator.radau import extend_stiff_step, try_stiff_step
from pddecont.simulate.integrator.rhs import evaluate_rhs
from pddecont.simulate.integrator.state import HELD, HELD_LENGTH, IN_STEP, MODE, OVERLAPS, UNKNOWN

# Repetitions of one step: a contraction by a half leaves 2^-30 of the first error, and slower ones want shorter steps.
MAX_REPETITIONS = 30
# What the last repetition may still change, in errors of the step, or in tolerances where these are less.
REPETITION_TOL = 1e-3
# The error that asks for a step a third to a half as long, whatever the order: there the repetitions converge faster.
NOT_CONVERGED = 1e3


@internal
def try_any_step(c, t, h):
    """Try a step as :func:`try_explicit_step` or :func:`try_stiff_step` do; one that reads itself is repeated."""
    c.lag_count[HELD], c.lag_count[OVERLAPS], c.lag_count[UNKNOWN] = 0, 0, 0
    for k in range(c.n_varying):
        c.lag_least[k], c.lag_most[k] = math.inf, -math.inf
    error = try_stiff_step(c, t, h) if c.stiff == 1 else try_explicit_step(c, t, h)
    if c.lag_count[OVERLAPS] == 0 or not math.isfinite(error):
        return error
    last = math.inf
    _extend_step(c, t, h)
    hold_extension(c, h)
    for repetition in range(MAX_REPETITIONS):
        evaluate_rhs(c, c.count[MODE], t, c.y, c.stages)
        error = try_stiff_step(c, t, h) if c.stiff == 1 else try_explicit_step(c, t, h)
        if not math.isfinite(error):
            return error
        _extend_step(c, t, h)
        change = _measure_change(c)
        hold_extension(c, h)
        if not math.isfinite(change):
            return math.inf
        if change <= REPETITION_TOL * min(1.0, error):
            return error
        # Changes as small as rounding in an extension shrink no further.
        if repetition > 1 and change >= last:
            return error if change <= 1.0 else NOT_CONVERGED
        last = change
    return NOT_CONVERGED


@internal
def _extend_step(c, t, h):
    if c.stiff == 1:
        extend_stiff_step(c)
    else:
        extend_explicit_step(c, t, h)


@internal
def _measure_change(c):
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


@internal
def hold_extension(c, h):
    """Let what reads the present step, of length ``h``, read the extension that it has now."""
    for i in range(N_COEFFICIENTS * c.dimension):
        c.held[i] = c.extension[i]
    c.lag_count[HELD], c.lag_time[HELD_LENGTH] = 1, h


@internal
def enter_step(c):
    """Let lags that vary read the pieces that they read now, all through the step to come."""
    c.lag_count[IN_STEP] = 1


@internal
def leave_step(c):
    """Let what is read come from the steps that are recorded again."""
    c.lag_count[HELD], c.lag_count[IN_STEP] = 0, 0
