"""A zero near a point, and the largest box around it in which it is proved to be the only one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np

from pddecont.intervals.arithmetic import Array, Bools, make_interval, make_point
from pddecont.intervals.boxes import Boxes, make_box
from pddecont.intervals.contraction import Rows, invert_matrices, is_regular, precondition
from pddecont.intervals.enclosure import Enclosure

# Steps of Newton's method from the midpoint of a box.
STEPS = 20
# Steps below this part of the region no longer shrink as they should when rounding errors stop them.
CONVERGED = 1e-9
# Boxes tried around a zero: from the size of the region down, each half as wide as the one before.
HALVINGS = 48
# A zero at the edge of where equations are defined is one if they are zero within so many rounding errors of it.
ROUNDINGS = 16.0


@dataclass(frozen=True, eq=False)
class Zone:
    """A ``point`` (n_variables,) beside which the box ``around`` holds no other zero."""

    point: Array
    around: Boxes


def find_zone(equations: Enclosure, guess: Array, sizes: Array, limits: Boxes) -> Zone | None:
    """Return the zero near a guess with what is proved; None where nothing can be.

    ``sizes`` (n_variables,) are those of the unknowns in the region ``limits``.
    """
    point = _polish(equations, guess, sizes)
    if point is None:
        return None
    radii = sizes[:, None] * 0.5 ** np.arange(HALVINGS)
    around = Boxes(point[:, None] - radii, point[:, None] + radii)
    near, smooth = _linearise(equations, point, around)
    proved = smooth & _list_proved(near, point, around)
    if not np.any(smooth):
        # The equations end beside the point: they are asked on the side of the region.
        point = np.clip(point, limits.low[:, 0], limits.high[:, 0])
        around = Boxes(np.maximum(around.low, limits.low), np.minimum(around.high, limits.high))
        near, smooth = _linearise(equations, point, around)
        proved = smooth & is_regular(near.slopes, around.widths)
        proved &= _is_zero_to_rounding(equations, point, sizes, limits)
    if not np.any(proved):
        return None
    largest = int(np.argmax(proved))
    return Zone(point, around[largest : largest + 1])


def _polish(equations: Enclosure, guess: Array, sizes: Array) -> Array | None:
    """Return where Newton's method leads."""
    at, last = guess[:, None], np.inf
    for _ in range(STEPS):
        values, slopes = equations.derivatives(at, at)
        if not (np.all(values.is_bounded) and np.all(slopes.is_bounded)):
            return None
        step = -np.einsum("jk,k->j", invert_matrices(slopes.middle)[:, :, 0], values.middle[:, 0])
        size = float(np.max(np.abs(step) / sizes))
        if not np.isfinite(size) or size > 1.0:
            return None
        at = at + step[:, None]
        if size == 0.0 or (size < CONVERGED and size >= 0.5 * last):
            return np.asarray(at[:, 0])
        last = size
    return None


def _list_proved(near: Rows, point: Array, around: Boxes) -> Bools:
    """Return in which boxes Krawczyk's operator proves that there is one zero, and no other."""
    center = make_point(point[:, None])
    away = make_interval(around.low, around.high) - center
    rest = make_point(np.eye(len(point))[:, :, None]) - near.slopes
    image = center - near.values + reduce(add, (rest[:, k] * away[k][None] for k in range(len(point))))
    return np.asarray(np.all((image.low > around.low) & (image.high < around.high), axis=0))


def _linearise(equations: Enclosure, point: Array, around: Boxes) -> tuple[Rows, Bools]:
    """Return preconditioned rows over boxes around a point, and where they hold all over the box."""
    values, slopes = equations.derivatives(around.low, around.high)
    smooth = np.all(values.sure, axis=0) & np.all(slopes.is_bounded, axis=(0, 1))
    at = np.broadcast_to(point[:, None], around.low.shape)
    return precondition(Rows(slopes, equations.values(at, at))), smooth


def _is_zero_to_rounding(equations: Enclosure, point: Array, sizes: Array, limits: Boxes) -> bool:
    """Return whether equations may be zero at a point, given its rounding errors."""
    error = ROUNDINGS * np.finfo(float).eps * np.maximum(sizes, np.abs(point))
    box = make_box(np.maximum(point - error, limits.low[:, 0]), np.minimum(point + error, limits.high[:, 0]))
    return bool(np.all(equations.values(box.low, box.high).holds_zero))
