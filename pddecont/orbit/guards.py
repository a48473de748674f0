"""How far the conditions of an orbit's segments are from changing: which mode follows an event hangs on them.

The distance is that of the comparisons' sides, counted in what they change by when each state, delayed value and time
moves by its size, so that units do not matter; ``and`` takes the least, ``or`` the largest.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy.logic.boolalg import Boolean

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
    return orbit.once("guards", lambda: _measure_guards(orbit))[s]


def _measure_guards(orbit: Orbit) -> list[float]:
    """Return how far the condition of each segment is from changing."""
    guards = [segment.guard for segment in orbit.signature.segments]
    every = tuple(dict.fromkeys(e for guard in guards for e in list_differences(guard)))
    values, sizes = evaluate_after(orbit, range(len(guards)), every)
    # A comparison need not have a value at segments that do not ask for it.
    with np.errstate(invalid="ignore"):
        columns = (values / sizes).T.tolist()
    return [combine_differences(g, dict(zip(every, c, strict=True))) for g, c in zip(guards, columns, strict=True)]


def evaluate_after(orbit: Orbit, segments: Sequence[int], exprs: Sequence[sympy.Expr]) -> tuple[Array, Array]:
    """Return expressions after the event and the reset at the ends of some segments, and their sizes.

    The size is what one changes by when states, delayed values and time move by their sizes. Both have the shape
    (n_exprs, len(segments)).
    """
    numeric = orbit.numeric
    reads, at = read_starts(orbit), (np.asarray(segments, dtype=np.intp) + 1) % len(orbit.signature)
    function = numeric.function(exprs)
    found = function.derivatives(reads.t[at], reads.x[:, at], reads.xd[:, at], orbit.parameters)
    where = function.structure()
    sizes = measure_states(orbit.values)
    delayed = np.array([sizes[read.state] / orbit.period**read.derivative for read in numeric.model.delayed])
    integrals = orbit.equation_reads.xd[len(delayed) :]
    delayed = np.concatenate([delayed, measure_states(integrals.T)])
    change = np.zeros(found.value.shape)
    np.add.at(change, where.dx[0], np.abs(found.dx) * sizes[where.dx[1]][:, None])
    np.add.at(change, where.dxd[0], np.abs(found.dxd) * delayed[where.dxd[1]][:, None])
    np.add.at(change, where.dt, np.abs(found.dt) * orbit.period)
    # What parameters alone make has no size; its own number tells the side.
    return found.value, np.where(change > 0.0, change, 1.0)


def is_alternative(signature: Signature, s: int, name: str) -> bool:
    """Return whether the segment called ``name`` is another way in which segment ``s`` may end."""
    model, own = signature.numeric.model, signature.segments[s]
    return any(other.name == name != own.name for other in list_alternatives(model, own))


def explain_guard(signature: Signature, s: int) -> Reason:
    """Return the reason that says that the condition of segment ``s`` does not hold."""
    segment = signature.segments[s]
    return make_reason(CODE, number=s + 1, segment=segment.name, condition=_print_condition(segment.guard))


@cache
def _print_condition(condition: Boolean) -> str:
    return str(condition)
