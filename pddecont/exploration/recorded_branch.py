"""A recorded branch in one parameter, asked whether a motion lies on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from pddecont.exploration.fingerprint import Fingerprint, are_as_long, fingerprint_orbits, is_multiple
from pddecont.exploration.symmetry import Symmetry
from pddecont.results import Step

Array = NDArray[np.float64]
# A motion lies on a branch if it differs from what lies between two of its points by this part of its size ...
CLOSE = 2e-3
# ... and by this part of what these points differ by, as interpolation may be so wrong.
SLACK = 0.1
# Special points of different branches are one if they differ by this part of their size.
ALIKE = 1e-2
# Values of a parameter that differ by less than this part of its range are one.
SAME_VALUE = 1e-7
TINY = float(np.finfo(float).tiny)
# Where two points of a branch are one: beside each other to this part of its length.
SAME_PLACE = 1e-9
# The kind of point at which a branch ends, which is special in no other way.
END = "EP"


@dataclass(frozen=True)
class Place:
    """Where a motion lies: on which branch, as the image by which symmetry, and whether the branch is stable there.

    ``is_stable`` is None where that is not known.
    """

    branch: str
    symmetry: Symmetry
    is_stable: bool | None


@dataclass(frozen=True, eq=False)
class RecordedBranch:
    """A branch in the order of its arclength.

    Attributes
    ----------
    step
        What the file holds of it.
    rows
        Its rows in order (n_points,).
    parameter
        The free parameter along it (n_points,).
    width
        The width of its range.
    motions
        What each of its motions is (n_points).
    scale
        How far motions of the model go (n_states,).
    symmetries
        Those of the model, the identity first.
    """

    step: Step
    rows: NDArray[np.intp]
    parameter: Array
    width: float
    motions: list[Fingerprint]
    scale: Array
    symmetries: tuple[Symmetry, ...]

    @property
    def name(self) -> str:
        """The step's name."""
        return self.step.name

    def find_place(self, motion: Fingerprint, value: float) -> Place | None:
        """Return where on the branch a motion at a value of the parameter lies; None if it does not.

        Where it may be several places it is one at which the branch is stable.
        """
        found = None
        for symmetry in self.symmetries:
            image = motion.apply(symmetry)
            for is_stable in self._list_places(image, value):
                if is_stable:
                    return Place(self.name, symmetry, is_stable)
                found = found or Place(self.name, symmetry, is_stable)
        return found

    def list_images(self) -> list[Symmetry]:
        """Return the symmetries that make another branch of this one: those that do not leave its motions as they are.

        Its motions are those amid it: where it ends or branches they may be symmetric.
        """
        middle = self.motions[len(self.motions) // 2]
        return [one for one in self.symmetries[1:] if not self.is_alike(middle.apply(one), middle)]

    def is_alike(self, motion: Fingerprint, other: Fingerprint) -> bool:
        """Return whether two motions at one value of the parameter cover the same states, whatever their periods."""
        size = motion.measure_size(self.scale)
        return bool(np.all(np.abs(motion.values - other.values) <= ALIKE * size))

    def _list_places(self, motion: Fingerprint, value: float) -> Iterator[bool | None]:
        """Yield for each place at which a motion lies on the branch whether the branch is stable there."""
        here, edge = self.parameter - value, SAME_VALUE * self.width
        if len(here) == 1:
            if abs(float(here[0])) < edge and self._is_close(motion, self.motions[0], 0.0):
                yield self._is_stable(0, 0)
            return
        between = (np.minimum(here[:-1], here[1:]) <= edge) & (np.maximum(here[:-1], here[1:]) >= -edge)
        for k in map(int, np.flatnonzero(between)):
            if self._holds_between(k, motion, value):
                yield self._is_stable(k, k + 1)

    def _is_stable(self, *places: int) -> bool | None:
        """Return whether the branch is stable between two points; None if that is not known.

        Stability changes at special points, which are stable themselves but for what is critical there.
        """
        rows = [self.rows[k] for k in places]
        flags = [int(self.step.points["stable"][row]) for row in rows if self.step.kind_of(int(row)) in ("", END)]
        known = [flag for flag in flags if flag >= 0]
        return any(known) if known else None

    def _holds_between(self, k: int, motion: Fingerprint, value: float) -> bool:
        """Return whether a motion lies between the points ``k`` and ``k + 1``."""
        before, after = self.motions[k : k + 2]
        apart = np.abs(after.values - before.values)
        from_middle = np.abs(motion.values - 0.5 * (before.values + after.values))
        # What is far from both need not be compared with what lies between them.
        if np.any(from_middle > apart + motion.measure_size(self.scale)):
            return False
        share, values = self._interpolate(k, value)
        if not are_as_long(before.period, after.period):
            # Here the branch is written with another number of periods on either side.
            return any(self._is_close(motion, Fingerprint(end.period, values), apart) for end in (before, after))
        period = (1.0 - share) * before.period + share * after.period
        return self._is_close(motion, Fingerprint(period, values), apart, abs(after.period - before.period))

    def _is_close(
        self, motion: Fingerprint, expected: Fingerprint, apart: Array | float, periods_apart: float = 0.0
    ) -> bool:
        """Return whether a motion is what is expected between points that are so far apart."""
        allowed = CLOSE * motion.measure_size(self.scale) + SLACK * apart
        if np.any(np.abs(motion.values - expected.values) > allowed):
            return False
        relative = SLACK * periods_apart / expected.period if expected.period > 0.0 else 0.0
        # A branch may be written with several periods of its orbits; a motion has its own.
        return is_multiple(expected.period, motion.period, relative)

    def _interpolate(self, k: int, value: float) -> tuple[float, Array]:
        """Return where between two points the parameter has a value, from 0 to 1, and what is expected there (4, n)."""
        places = self.step.points["arclength"][self.rows]
        length = max(float(np.ptp(places)), TINY)
        # Special points may lie just where others do.
        near = np.arange(max(0, k - 2), min(len(places), k + 4))
        chosen = near[np.concatenate([[True], np.diff(places[near]) > SAME_PLACE * length])]
        a, b = places[[k, k + 1]]
        nearer = int(abs(self.parameter[k] - value) > abs(self.parameter[k + 1] - value))
        if len(chosen) < 2 or b - a <= SAME_PLACE * length:
            return float(nearer), self.motions[k + nearer].values
        along = _interpolate_through(places[chosen], self.parameter[chosen])
        if (float(along(a)) - value) * (float(along(b)) - value) >= 0.0:
            return float(nearer), self.motions[k + nearer].values
        place = brentq(lambda s: float(along(s)) - value, a, b)
        values = _interpolate_through(places[chosen], np.stack([self.motions[j].values for j in chosen]))(place)
        return (place - a) / (b - a), np.asarray(values)


def _interpolate_through(places: Array, values: Array) -> PchipInterpolator:
    """Return what runs through ``values`` (n, ...) at ``places`` (n,) and turns at none between them."""
    # Of slopes that are rounding the inverse may be too large: that of their mean is zero then, as it ought to be.
    with np.errstate(over="ignore"):
        return PchipInterpolator(places, values)


def read_branch(
    step: Step, parameter: str, width: float, scale: Array, symmetries: tuple[Symmetry, ...]
) -> RecordedBranch:
    """Return a recorded branch over a parameter whose range has a width."""
    rows = step.order
    values = step.points["parameters"][rows, list(step.meta["parameters"]).index(parameter)]
    return RecordedBranch(step, rows, values, width, fingerprint_orbits(step, rows), scale, symmetries)
