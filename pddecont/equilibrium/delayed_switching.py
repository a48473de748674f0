"""Where a law that switches on past values would rest if it switched at once: on its surface, between two modes.

The fields f and g of the modes on both sides of u = 0 push towards it: (1 - s) f + s g = 0 there for some 0 < s < 1.
With the delay no motion stays, since each side goes on for as long as the past is read: orbits go back and forth there,
as small as the delay is short.

Reference: Sieber, Nonlinearity 19 (2006) 2489-2527, section 2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.equations import Equilibrium
from pddecont.equilibrium.sides import SIGNS

Array = NDArray[np.float64]
# Newton steps at most, and the last one's size relative to the states'.
MAX_ITERATIONS, CLOSE = 30, 1e-12


@dataclass(frozen=True, eq=False)
class DelayedSwitching:
    """States (n_states,) on the surface of an ``event`` of past values, to which two ``modes`` push from both sides."""

    event: str
    modes: tuple[str, str]
    states: Array


def find_delayed_switchings(guess: Equilibrium) -> list[DelayedSwitching]:
    """Return the places near a guess where a law that switches on past values cannot rest, one for each surface."""
    motion, found = guess.motion, []
    seen: set[str] = set()
    for segment in motion.numeric.model.list_segments(motion.mode):
        if not segment.event or segment.event in seen or segment.direction not in SIGNS:
            continue
        if not _reads_past(guess, segment.event):
            continue
        states = _solve(guess, segment.event, segment.to, SIGNS[segment.direction])
        if states is not None:
            seen.add(segment.event)
            found.append(DelayedSwitching(segment.event, (motion.mode, segment.to), states))
    return found


def _reads_past(at: Equilibrium, event: str) -> bool:
    """Return whether an event's function reads values from a time ago, or integrals over it."""
    numeric, reads = at.motion.numeric, at.motion.reads
    columns = np.unique(numeric.event(event).structure().dxd[1]).tolist()
    lags = reads.find_lags(at.states, at.motion.read(at.states, at.parameters), at.parameters)
    delayed = numeric.model.delayed
    return any(k >= len(delayed) or lags[delayed[k].delay] > 0.0 for k in columns)


def _solve(guess: Equilibrium, event: str, other: str, towards: float) -> Array | None:
    """Return the states between two modes on an event's surface, by Newton's method; None where there are none."""
    motions = (guess.motion, replace(guess.motion, mode=other))
    x, share, n = guess.states.copy(), 0.5, len(guess.states)
    for _ in range(MAX_ITERATIONS):
        (f, f_x, _), (g, g_x, _) = (_dense(motion.differentiate(x, guess.parameters, ())) for motion in motions)
        u, slopes, _ = guess.motion.measure_event(event, x, guess.parameters)
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n], matrix[:n, n], matrix[n, :n] = (1.0 - share) * f_x + share * g_x, g - f, slopes
        try:
            step = np.linalg.solve(matrix, -np.append((1.0 - share) * f + share * g, u))
        except np.linalg.LinAlgError:
            return None
        x, share = x + step[:n], share + float(step[n])
        if not np.all(np.isfinite(x)):
            return None
        if np.max(np.abs(step[:n])) <= CLOSE * (1.0 + np.max(np.abs(x))):
            # The first mode has to push to where it ends, and the other one back.
            return x if 0.0 < share < 1.0 and towards * float(slopes @ f) > 0.0 else None
    return None


def _dense(given: tuple[Array, object, Array]) -> tuple[Array, Array, Array]:
    value, in_x, in_p = given
    return value, in_x if isinstance(in_x, np.ndarray) else in_x.toarray(), in_p  # type: ignore[attr-defined]
