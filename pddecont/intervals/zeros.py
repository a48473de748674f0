"""All zeros of equations in a box, by branch and prune: boxes that can hold none are left out, others are cut in two.

A box is done with when it is empty, or its only zero is known. What is left when boxes are too small or too many is
undecided. Boxes are examined in the order in which they were made, many at a time, so that a place where nothing can be
decided does not keep the others waiting.

Reference: Hansen, Walster, Global Optimization Using Interval Analysis (2004), chapter 11.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pddecont.intervals.arithmetic import Array, Bools
from pddecont.intervals.boxes import Boxes, join_boxes, make_box, merge_boxes
from pddecont.intervals.contraction import Outcome, contract
from pddecont.intervals.enclosure import Enclosure
from pddecont.intervals.proof import Zone, find_zone

# Boxes examined at a time, and in all; fewer of more than so many unknowns, whose matrices are larger.
MANY = 2048
BUDGET = 60_000
UNKNOWNS = 8
# A box narrower than this part of the region is not cut any more.
SMALLEST = 2.0**-26
# A box that was made narrower by this factor is examined anew before it is cut.
SHRUNK = 0.5
# A box that holds no more than one zero is taken for that zero itself below this part of the region.
CLOSE = 1e-5
# A box of so few doubles is not cut any more.
ULPS = 8.0
# A zero this close to the edge of the region, relative to its size, lies in it.
EDGE = 1e-12


@dataclass(frozen=True, eq=False)
class Zeros:
    """The zeros in a box.

    ``points`` (n_zeros, n_variables) are all of them if there are no ``undecided`` boxes, which may hold more.
    """

    points: Array
    undecided: Boxes
    n_examined: int


def find_zeros(equations: Enclosure, low: Array, high: Array, sizes: Array, budget: int = BUDGET) -> Zeros:
    """Return the zeros between ``low`` and ``high`` (n_variables,), as many equations as unknowns.

    ``sizes`` (n_variables,) are the widths of this region; an unknown that has one value there has a size all the same.
    """
    search = _Search(equations, make_box(low, high), sizes)
    queue, n_examined = search.region, 0
    share = min(1.0, (UNKNOWNS / max(len(low), 1)) ** 2)
    many = max(int(share * MANY), 1)
    with np.errstate(all="ignore"):
        while len(queue) and n_examined < share * budget:
            now, later = queue[:many], queue[many:]
            n_examined += len(now)
            queue = join_boxes([later, search.examine(now)])
    left = join_boxes([*search.undecided, search.drop_known(queue)])
    return Zeros(search.list_points(), merge_boxes(left, sizes), n_examined)


@dataclass(eq=False)
class _Search:
    """A search under way in a ``region``, which is one box."""

    equations: Enclosure
    region: Boxes
    sizes: Array
    zones: list[Zone] = field(default_factory=list)
    undecided: list[Boxes] = field(default_factory=list)

    def examine(self, boxes: Boxes) -> Boxes:
        """Return the boxes in which to look on."""
        outcome = contract(self.equations, self.drop_known(boxes))
        outcome = outcome[~self._find_done(outcome)]
        left, width = outcome.left, self._measure(outcome.left)
        small = self._is_small(left)
        shrunk, was_small = width < SHRUNK * self._measure(outcome.before), self._is_small(outcome.before)
        self.undecided.append(left[small & was_small])
        again = (small | shrunk) & ~was_small
        return join_boxes([left[again], left[~again & ~was_small].bisect(self.sizes)])

    def drop_known(self, boxes: Boxes) -> Boxes:
        """Return the boxes that do not lie beside a zero that is known."""
        for zone in self.zones:
            boxes = boxes[~boxes.lie_in(zone.around)]
        return boxes

    def list_points(self) -> Array:
        """Return the zeros in the region."""
        low, high = (
            end[:, 0] + sign * EDGE * self.sizes for end, sign in ((self.region.low, -1.0), (self.region.high, 1.0))
        )
        points = [zone.point for zone in self.zones if np.all((zone.point >= low) & (zone.point <= high))]
        return np.array(points).reshape(-1, len(low))

    def _find_done(self, outcome: Outcome) -> Bools:
        """Return which boxes hold no zero beside one that is known, looking for those that are not."""
        done, left = np.zeros(len(outcome.left), dtype=bool), outcome.left
        ready = outcome.single & (outcome.is_inside | (self._measure(left) < CLOSE))
        for k in np.flatnonzero(ready).tolist():
            box = left[k : k + 1]
            zone = self._find_zone(box)
            done[k] = zone is not None and (self._holds(box, zone.point) or bool(box.lie_in(zone.around)[0]))
        return done

    def _find_zone(self, box: Boxes) -> Zone | None:
        """Return the zone of the zero near a box."""
        known = next((zone for zone in self.zones if box.lie_in(zone.around)[0]), None)
        zone = known or find_zone(self.equations, box.center[:, 0], self.sizes, self.region)
        if zone is None or known is not None:
            return known
        same = next((other for other in self.zones if self._holds(other.around, zone.point)), None)
        if same is None:
            self.zones.append(zone)
        return same or zone

    def _holds(self, box: Boxes, point: Array) -> bool:
        """Return whether a point lies in a box, or as close as rounding errors."""
        edge = EDGE * self.sizes
        return bool(np.all((point >= box.low[:, 0] - edge) & (point <= box.high[:, 0] + edge)))

    def _measure(self, boxes: Boxes) -> Array:
        """Return the largest width of each box relative to the region (n_boxes,)."""
        return np.asarray(np.max(boxes.widths / self.sizes[:, None], axis=0, initial=0.0))

    def _is_small(self, boxes: Boxes) -> Bools:
        """Return which boxes are too small to be cut (n_boxes,)."""
        ends = np.maximum(np.abs(boxes.low), np.abs(boxes.high))
        least = np.maximum(SMALLEST * self.sizes[:, None], ULPS * np.spacing(ends))
        return np.asarray(np.all(boxes.widths <= least, axis=0))
