"""One step: its length, the arcs that its delays read, and tries until the tolerances accept one."""

from __future__ import annotations

from math import isfinite, sqrt

from pddecont.native.integrator.core import Core
from pddecont.native.integrator.dop853 import (
    N_STAGES,
    estimate_extension_error,
    extend_explicit_step,
    try_explicit_step,
)
from pddecont.native.integrator.event_sides import note_sides
from pddecont.native.integrator.history import choose_arcs
from pddecont.native.integrator.lag_crossing import check_lags, choose_pieces
from pddecont.native.integrator.overlap import enter_step, hold_extension, try_any_step
from pddecont.native.integrator.places import FRESH, MODE, N_REJECTED, READY, UNKNOWN
from pddecont.native.integrator.radau import extend_stiff_step, try_stiff_step
from pddecont.native.integrator.rhs import evaluate_rhs
from pddecont.native.integrator.ring import time_tolerance
from pddecont.native.integrator.status import Status
from pddecont.native.integrator.variational import choose_arcs_with_tangent

# After an error e of a method of order q the next step is SAFETY e^(-1/q) times as long, within bounds. Safety and
# growth are those of the code DOP853 (Hairer, Norsett, Wanner I, appendix), the bound below is that of scipy.integrate.
SAFETY, SHRINK, GROW = 0.9, 0.2, 6.0
# The powers of the step with which the error estimates go: Radau IIA of order 5 has one of order 3.
EXPLICIT_ORDER, STIFF_ORDER = 8.0, 4.0
# A step that leads to infinity or NaN says nothing about how much shorter it has to be.
NOT_FINITE_SHRINK = 0.1
# A step may be longer by a hundredth to reach its stop: no short one is left over.
STRETCH = 1.01
# A step has to be longer than so many tolerances of time.
SHORTEST = 4.0
# For the first step: a solution or a slope is zero below this mean square (1e-5 of the tolerances, section II.4), the
# step is then this part of the time, and else this part of the time that the solution needs to change by its own size.
ZERO, FIRST_PART, PART_OF_CHANGE = 1e-10, 1e-4, 0.01


def make_step(c: Core, t: float, stop: float) -> tuple[float, int]:
    """Make one step that the tolerances accept, towards ``stop``; return its length and a status.

    The values at its end are in the second row of ``c.trial``, its extension in ``c.extension``.
    """
    status = _begin_step(c, t, min(stop - t, c.max_step))
    if status != Status.REACHED:
        return 0.0, status
    if c.is_general == 1:
        enter_step(c)
    h, status = _find_accepted_step(c, t, stop - t)
    if status != Status.REACHED:
        return h, status
    if c.stiff == 1:
        extend_stiff_step(c)
    if c.is_general == 1:
        hold_extension(c, h)
        if c.lag_count[UNKNOWN] == 1:
            return h, Status.PAST_UNKNOWN
    return h, Status.REACHED


def _begin_step(c: Core, t: float, first: float) -> int:
    """Choose what the delays read, evaluate the slope, and choose a length if there is none; return a status.

    The slope is left in the first row of ``c.stages``. No first step is longer than ``first``.
    """
    mode = c.count[MODE]
    middle = t + 0.5 * _trial_length(c, first)
    changed = choose_arcs_with_tangent(c, t, middle) if c.tangent == 1 else choose_arcs(c, middle)
    if c.is_general == 1 and c.count[FRESH] == 1:
        choose_pieces(c, t)
    c.lag_count[UNKNOWN] = 0
    if changed or c.count[READY] == 0 or c.stiff == 1 or c.is_general == 1:
        evaluate_rhs(c, mode, t, c.y, c.stages)
    else:
        for i in range(c.dimension):
            c.stages[i] = c.stages[N_STAGES * c.dimension + i]
    if c.is_general == 1:
        status = check_lags(c, t)
        if status != Status.REACHED:
            return status
    if c.next_step[mode] == 0.0:
        c.next_step[mode] = _choose_first_length(c, t, first)
        choose_arcs(c, t + 0.5 * _trial_length(c, first))
    if c.count[FRESH] == 1:
        note_sides(c, t)
    return Status.REACHED


def _find_accepted_step(c: Core, t: float, rest: float) -> tuple[float, int]:
    """Try steps, each shorter than the one before, until the tolerances accept one; return its length and a status.

    The stop is at a distance of ``rest``. How long the next step may be is left in ``c.next_step``.
    """
    mode = c.count[MODE]
    wanted = min(c.next_step[mode], c.max_step)
    order = STIFF_ORDER if c.stiff == 1 else EXPLICIT_ORDER
    rejected = False
    while True:
        h = wanted if STRETCH * wanted < rest else rest
        if rest > h > 0.5 * rest:
            h = 0.5 * rest
        if h <= SHORTEST * time_tolerance(t) and h < rest:
            return h, Status.STEP_TOO_SMALL if _is_finite(c) else Status.NOT_FINITE
        error = _try_step(c, t, h)
        if error <= 1.0:
            factor = GROW if error == 0.0 else min(GROW, max(SHRINK, SAFETY * error ** (-1.0 / order)))
            if rejected:
                factor = min(factor, 1.0)
            # A step cut short by a breaking point says nothing against the length that was wanted.
            c.next_step[mode] = max(h * factor, c.next_step[mode]) if h < 0.99 * wanted and not rejected else h * factor
            return h, Status.REACHED
        c.count[N_REJECTED] += 1
        rejected = True
        wanted = h * (NOT_FINITE_SHRINK if not isfinite(error) else max(SHRINK, SAFETY * error ** (-1.0 / order)))


def _try_step(c: Core, t: float, h: float) -> float:
    """Make a step of length ``h``, with its extension if anything reads that; return its error in parts of what may be.

    Delays, events, the section and the log read the extension of a step.
    """
    if c.is_general == 1:
        error = try_any_step(c, t, h)
    else:
        error = try_stiff_step(c, t, h) if c.stiff == 1 else try_explicit_step(c, t, h)
    # What reads inside the step sees the extension's error.
    within = (c.n_delays > 0 and c.chain_n == 0) or c.n_segments > 0 or c.is_general == 1
    if error <= 1.0 and c.stiff == 0 and (within or c.section >= 0 or c.log_steps > 0):
        extend_explicit_step(c, t, h)
        if within:
            error = max(error, estimate_extension_error(c, t, h))
    return error


def _is_finite(c: Core) -> bool:
    """Return whether the present state and its slope are finite."""
    for i in range(c.dimension):
        if not isfinite(c.y[i]) or not isfinite(c.stages[i]):
            return False
    return True


def _trial_length(c: Core, first: float) -> float:
    """Return the length of the step to come as far as it is known: ``first`` where nothing else is."""
    return first if c.next_step[c.count[MODE]] == 0.0 else min(first, c.next_step[c.count[MODE]])


def _choose_first_length(c: Core, t: float, longest: float) -> float:
    """Return a first step length, from the sizes of the solution and its slope.

    Reference: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.4, step a of the
    algorithm for the starting step size.

    A state at zero whose unit is small beside the absolute tolerance seems to change at once: no step is tried that
    times cannot tell from none, and the next ones grow.
    """
    size, slope = 0.0, 0.0
    for i in range(c.n_full):
        allowed = c.atol + c.rtol * abs(c.y[i])
        size += (c.y[i] / allowed) ** 2
        slope += (c.stages[i] / allowed) ** 2
    if slope <= ZERO or size <= ZERO:
        return min(longest, FIRST_PART * max(1.0, abs(t)))
    return min(longest, max(PART_OF_CHANGE * sqrt(size / slope), GROW * SHORTEST * time_tolerance(t)))
