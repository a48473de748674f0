"""How far the conditions of an orbit's segments are from changing: which mode follows an event hangs on them.

The distance is that of the comparisons' sides, counted in what they change by when each state, delayed value and time
moves by its size, so that units do not matter; ``and`` takes the least, ``or`` the largest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.model import combine_differences, list_alternatives, list_differences
from pddecont.orbit.error import measure_states
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.signature import Signature
from pddecont.orbit.starts import read_starts
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]
CODE = "guard"


def list_guarded(signature: Signature) -> list[int]:
    """Return the segments that lead where they do by a condition."""
    return [s for s, segment in enumerate(signature.segments) if list_differences(segment.guard)]


def measure_guard(orbit: Orbit, s: int) -> float:
    """Return how far the condition of segment ``s`` is from changing: positive where it holds, zero where it begins to.

    It is judged by the states after the reset at the segment's end.
    """
    guard = orbit.signature.segments[s].guard
    differences = list_differences(guard)
    values, sizes = evaluate_after(orbit, s, differences)
    return combine_differences(guard, dict(zip(differences, (values / sizes).tolist(), strict=True)))


def evaluate_after(orbit: Orbit, s: int, exprs: Sequence[sympy.Expr]) -> tuple[Array, Array]:
    """Return expressions after the event and the reset at the end of segment ``s``, and their sizes (n_exprs,).

    The size is what one changes by when states, delayed values and time move by their sizes.
    """
    numeric, following = orbit.numeric, (s + 1) % len(orbit.signature)
    reads, at = read_starts(orbit), [following]
    function = numeric.function(exprs)
    found = function.derivatives(reads.t[at], reads.x[:, at], reads.xd[:, at], orbit.parameters)
    where = function.structure()
    sizes = measure_states(orbit.values)
    delayed = np.array([sizes[read.state] / orbit.period**read.derivative for read in numeric.model.delayed])
    integrals = orbit.equation_reads.xd[len(delayed) :]
    delayed = np.concatenate([delayed, measure_states(integrals.T)])
    change = np.zeros(len(exprs))
    np.add.at(change, where.dx[0], np.abs(found.dx[:, 0]) * sizes[where.dx[1]])
    np.add.at(change, where.dxd[0], np.abs(found.dxd[:, 0]) * delayed[where.dxd[1]])
    np.add.at(change, where.dt, np.abs(found.dt[:, 0]) * orbit.period)
    # What parameters alone make has no size; its own number tells the side.
    return found.value[:, 0], np.where(change > 0.0, change, 1.0)


def is_alternative(signature: Signature, s: int, name: str) -> bool:
    """Return whether the segment called ``name`` is another way in which segment ``s`` may end."""
    model, own = signature.numeric.model, signature.segments[s]
    return any(other.name == name != own.name for other in list_alternatives(model, own))


def explain_guard(signature: Signature, s: int) -> Reason:
    """Return the reason that says that the condition of segment ``s`` does not hold."""
    segment = signature.segments[s]
    return make_reason(CODE, number=s + 1, segment=segment.name, condition=str(segment.guard))
