"""How fast the tangent of a motion grows: what largest Lyapunov exponents are made of."""

from __future__ import annotations

from math import inf, isfinite, isnan, log, nan

from pddecont.native.arrays import Floats, entry
from pddecont.native.integrator.advance import run
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.places import FIRST, LONGEST, N_COEFFICIENTS, N_PENDING, SHIFT, USED, T
from pddecont.native.integrator.poincare import STEPS
from pddecont.native.integrator.status import Status


@entry
def measure_growth(c: Core, interval: float, n: int, logs: Floats, done: Floats) -> int:
    """Write the logarithm of the growth of the tangent over each of ``n`` intervals to ``logs``; return a status.

    CAPACITY asks for a larger state. ``done`` (2,) keeps for the next call how many intervals are done and when the
    present one ends (NaN: none is under way); it begins with (0, NaN).
    """
    k = 0
    if done[0] == 0.0 and isnan(done[1]):
        _rescale_tangent(c)
    while k < n:
        if k < done[0]:
            k += 1
            continue
        if isnan(done[1]):
            done[1] = c.clock[T] + interval
        status: int = Status.SECTION
        while status == Status.SECTION:
            status = run(c, done[1], STEPS)
        if status != Status.REACHED:
            return status
        logs[k] = _rescale_tangent(c)
        done[0], done[1] = k + 1.0, nan
        if not isfinite(logs[k]):
            break
        k += 1
    return Status.REACHED


def _rescale_tangent(c: Core) -> float:
    """Make the tangent, with its past, of length 1; return the logarithm of the length that it had.

    Where lags vary more of the past is kept than they are known to read: its length is that of what they read.
    """
    full, kept = c.n_full, c.n_kept
    n_past, first, end = kept * (1 + c.tangent), c.count[FIRST], c.count[FIRST] + c.count[USED]
    length, since = 0.0, -inf
    for i in range(full):
        length = max(length, abs(c.y[full + i]))
    if c.n_varying > 0:
        since = c.clock[T] - max(c.longest, c.lag_time[LONGEST])
    for number in range(first, end):
        j = number & c.mask
        if c.past_end[j] >= since:
            for k in range(kept):
                length = max(length, abs(c.past_value[j * n_past + kept + k]))
    if length == 0.0 or not isfinite(length):
        return -inf if length == 0.0 else inf
    for i in range(full):
        c.y[full + i] /= length
    for number in range(first, end):
        j = number & c.mask
        c.past_shift[j] /= length
        for k in range(kept):
            c.past_value[j * n_past + kept + k] /= length
            for i in range(N_COEFFICIENTS):
                c.past_coefficients[(j * N_COEFFICIENTS + i) * n_past + kept + k] /= length
    for k in range(c.count[N_PENDING]):
        c.pending_shift[k] /= length
    c.clock[SHIFT] /= length
    return log(length)
