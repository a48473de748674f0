"""What an exploration has found: branches, and the leads that led to them or nowhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from pddecont.exploration import Fingerprint, Place, RecordedBranch, is_multiple
from pddecont.reasons import Reason
from pddecont.steps.execution.explore_leads import DOUBLING, HALVED, Lead

# Two special points are one if their parameters differ by less than this part of the range.
SAME_PLACE = 1e-4
# The least share of a branch's points that lie on an earlier one for it to be the same.
REPEATED = 0.6
# Points of a branch that are looked for on earlier ones.
N_COMPARED = 7


@dataclass(frozen=True, eq=False)
class Entry:
    """What became of a lead: why, and the branch that came of it (None: none)."""

    lead: Lead
    reason: Reason
    branch: RecordedBranch | None = None


@dataclass(eq=False)
class Diagram:
    """Branches and leads in order of discovery."""

    entries: list[Entry] = field(default_factory=list)

    @property
    def branches(self) -> Iterator[RecordedBranch]:
        """The branches."""
        return (entry.branch for entry in self.entries if entry.branch is not None)

    def find(self, motion: Fingerprint, value: float) -> Place | None:
        """Return where on the branches a motion lies, if it may be on one that is stable there; None if on none."""
        found = None
        for branch in self.branches:
            place = branch.find_place(motion, value)
            if place is not None and place.is_stable:
                return place
            found = found or place
        return found

    def find_joined(self, lead: Lead) -> str | None:
        """Return what leads to the special point of a lead already: a branch, or an image of the point; None: nothing.

        It is a branch that ends or branches there, on the other side of the point, or one that was followed from its
        image by a symmetry.
        """
        for entry in self.entries:
            other = entry.lead
            if other.label == lead.label and entry.branch is not None and _is_near(lead, other.value, entry.branch):
                for image in (other.motion.apply(symmetry) for symmetry in entry.branch.symmetries):
                    if entry.branch.is_alike(lead.motion, image) and is_multiple(image.period, lead.motion.period):
                        return entry.branch.name
        for branch in self.branches:
            if branch.name != lead.step and _leads_to(branch, lead):
                return branch.name
        return None

    def find_repeated(self, branch: RecordedBranch) -> str | None:
        """Return the earlier branch that most points of another lie on; None if they do not lie on one."""
        inner = [k for k, row in enumerate(branch.rows) if not branch.step.kind_of(int(row))]
        chosen = [inner[int(i)] for i in np.linspace(0, len(inner) - 1, min(N_COMPARED, len(inner)))]
        for other in self.branches:
            on_it = [other.find_place(branch.motions[k], float(branch.parameter[k])) is not None for k in chosen]
            if chosen and np.mean(on_it) >= REPEATED:
                return other.name
        return None


def _is_near(lead: Lead, value: float, branch: RecordedBranch) -> bool:
    return abs(lead.value - value) <= SAME_PLACE * branch.width


def _leads_to(branch: RecordedBranch, lead: Lead) -> bool:
    """Return whether a special point of a branch is that of a lead from another."""
    for row, motion, value in zip(branch.rows, branch.motions, branch.parameter, strict=True):
        if not branch.step.kind_of(int(row)) or not _is_near(lead, float(value), branch):
            continue
        for image in (motion.apply(symmetry) for symmetry in branch.symmetries):
            if not branch.is_alike(lead.motion, image):
                continue
            # Beyond a period doubling the period is twice as long, but where the doubled orbits end it is the single
            # one's; where orbits are born they have none yet.
            ends = branch.step.reason(int(row)).code == HALVED
            twice = lead.label != DOUBLING or ends or image.period > 1.5 * lead.motion.period
            if twice and (lead.motion.period == 0.0 or is_multiple(image.period, lead.motion.period)):
                return True
    return False
