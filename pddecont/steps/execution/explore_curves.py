"""Curves of special points in two parameters: which are to be followed, and where they meet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import find_kind, find_other_kind
from pddecont.exploration import ALIKE, Fingerprint, RecordedBranch, are_as_long
from pddecont.results import Step
from pddecont.steps.execution.explore_leads import DOUBLING, Lead, LeadKind
from pddecont.steps.explore import ExploreSettings

Array = NDArray[np.float64]
# Special equilibria that are followed in two parameters, and points of their curves from which others go on, with
# whether that asks for the other branch.
OF_EQUILIBRIA = ("LP", "HB", "BE")
MEETING = {"BT": False, "ZH": False, "HH": False, "GH": True}
# Two points in the plane are one if they differ by less than this part of each range.
SAME_PLACE = 1e-3


@dataclass(frozen=True, eq=False)
class Curve:
    """A recorded curve: its kind, and its points in order along it.

    These are rows of its step (n_points,), their places in parts of the two ranges (n_points, 2), and their motions.
    """

    step: Step
    kind: str
    rows: NDArray[np.intp]
    places: Array
    motions: list[Fingerprint]

    def passes(self, place: Array) -> bool:
        """Return whether a place (2,) lies on the curve."""
        return len(self._find_near(place)[0]) > 0

    def holds(self, motion: Fingerprint, place: Array, scale: Array) -> bool:
        """Return whether a motion that is special at a place (2,) is one of the curve's, or lies between two of them.

        Curves of one kind may lie beside each other, as the grazings of an orbit and of the one that it doubled from.
        Of a period doubling the orbit or the doubled one may be recorded. ``scale`` is how far motions of the model go.
        """
        for k, along in zip(*self._find_near(place), strict=True):
            before, after = self.motions[k], self.motions[min(k + 1, len(self.motions) - 1)]
            period = (1.0 - along) * before.period + along * after.period
            if self.kind != DOUBLING and not are_as_long(period, motion.period):
                continue
            expected = (1.0 - along) * before.values + along * after.values
            allowed = ALIKE * motion.measure_size(scale) + np.abs(after.values - before.values)
            if np.all(np.abs(motion.values - expected) <= allowed):
                return True
        return False

    def _find_near(self, place: Array) -> tuple[NDArray[np.intp], Array]:
        """Return after which points the curve comes by a place, and where between them and the next it does (0 to 1).

        Shapes (n,).
        """
        if len(self.places) == 1:
            here = int(np.all(np.abs(self.places[0] - place) < SAME_PLACE))
            return np.zeros(here, dtype=np.intp), np.zeros(here)
        a, b = self.places[:-1], self.places[1:]
        chord = b - a
        length = np.maximum(np.sum(chord**2, axis=1), np.finfo(float).tiny)
        along = np.clip(np.sum((place - a) * chord, axis=1) / length, 0.0, 1.0)
        away = np.linalg.norm(a + along[:, None] * chord - place, axis=1)
        # Between two points a curve is not straight.
        near = np.flatnonzero(away < SAME_PLACE + 0.1 * np.sqrt(length))
        return near, along[near]


@dataclass(frozen=True, eq=False)
class Meeting:
    """A place (2,) in the plane, in parts of the ranges, at which special points of several curves are, by labels."""

    place: Array
    points: tuple[str, ...]


def read_curve(branch: RecordedBranch, settings: ExploreSettings) -> Curve:
    """Return a recorded curve, which was read as a branch."""
    step, kind = branch.step, str(branch.step.meta.get("curve") or "")
    return Curve(step, kind, branch.rows, _find_places(step, settings)[branch.rows], branch.motions)


def _find_places(step: Step, settings: ExploreSettings) -> Array:
    """Return the points of a step in parts of the two ranges, shape (n_points, 2)."""
    names = list(step.meta["parameters"])
    columns = [
        (step.points["parameters"][:, names.index(name)] - low) / (high - low)
        for name, (low, high) in settings.over.items()
    ]
    return np.column_stack(columns)


def list_curve_leads(branch: RecordedBranch, settings: ExploreSettings, depth: int) -> Iterator[tuple[Lead, Array]]:
    """Yield the special points of a branch that can be followed in two parameters, each with its place."""
    step, places = branch.step, _find_places(branch.step, settings)
    rests = "roots" in step.format.orbits
    for row, motion, value in zip(branch.rows, branch.motions, branch.parameter, strict=True):
        label = step.kind_of(int(row))
        kind = find_kind(label)
        if label in OF_EQUILIBRIA if rests else kind is not None and kind.define is not None:
            lead = Lead(LeadKind.SWITCH, step.name, step.labels[row], motion, float(value), depth, label)
            yield lead, places[row]


def list_meeting_leads(curve: Curve, branch: RecordedBranch) -> Iterator[tuple[Lead, Array, bool]]:
    """Yield the points of a curve from which another goes on, with whether it asks for a switch.

    Those of orbits have the label of that other curve.
    """
    rests = "roots" in curve.step.format.orbits
    for k, row in enumerate(curve.rows):
        kind = curve.step.kind_of(int(row))
        label = kind if rests else find_other_kind(kind, curve.kind)
        if label and (not rests or label in MEETING):
            motion, value = branch.motions[k], float(branch.parameter[k])
            lead = Lead(LeadKind.SWITCH, curve.step.name, curve.step.labels[row], motion, value, 0, label)
            yield lead, curve.places[k], MEETING.get(label, False)


def plan_curve(settings: ExploreSettings, lead: Lead, name: str, *, switch: bool) -> dict[str, Any]:
    """Return the step that follows a special point in two parameters."""
    follow: dict[str, Any] = {
        "from": {"step": lead.step, "point": lead.point},
        "free": list(settings.over),
        "range": {key: list(limits) for key, limits in settings.over.items()},
        "step": settings.body.step.model_dump(),
        "max_points": settings.body.max_points,
        "stability": True,
    }
    return {"name": name, "continue": follow | ({"branch": "switch"} if switch else {})}


def find_meetings(curves: Sequence[Curve]) -> list[Meeting]:
    """Return the places at which special points of several curves are one."""
    points = [
        (curve.places[k], f"{curve.step.name} {curve.step.labels[row]}", curve.step.name)
        for curve in curves
        for k, row in enumerate(curve.rows)
        if curve.step.kind_of(int(row)) not in ("", "EP")
    ]
    found: list[Meeting] = []
    taken: set[int] = set()
    for i, (place, _, _) in enumerate(points):
        near = [j for j, other in enumerate(points) if j >= i and np.all(np.abs(other[0] - place) < SAME_PLACE)]
        if i not in taken and len({points[j][2] for j in near}) > 1:
            found.append(Meeting(place, tuple(points[j][1] for j in near)))
        taken |= set(near)
    return found
