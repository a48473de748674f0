"""Whether an orbit is a motion of the model: a simulation from its own past says so.

From the middle of each segment the orbit's past is simulated to the middle of the next one. The simulation knows
nothing of the signature: it meets what events there are, delayed ones, jumps of delayed values over a surface and
surfaces at which nothing goes on too. Beginning anew in each segment keeps the orbit's instability out of the
comparison.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod, Direct
from pddecont.memo import cached_property
from pddecont.model import reads_generally
from pddecont.orbit.durations import find_instants
from pddecont.orbit.estimate import estimate_error
from pddecont.orbit.examination import FINE_RTOL, RTOL, Examination
from pddecont.orbit.judgement import ESTIMATED, judge
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.verdict import DRIFTS, Verification
from pddecont.reasons import make_reason
from pddecont.simulate import DrivenSimulator, Method, Simulator

# Where in a segment simulations begin and end: no part that a symmetry of the motion makes special, and others where a
# surface lies just there.
PLACES = (0.4789, 0.3217, 0.6481)


@dataclass(frozen=True, eq=False)
class Referee:
    """Simulates orbits of a model from their own past."""

    numeric: NumericModel
    delay: DelayMethod

    @cached_property
    def simulators(self) -> tuple[Simulator, ...]:
        """The model ready to be integrated, by an explicit method and by one for stiff models.

        Where a delay line holds the history, delayed values are what the orbit says.
        """
        made = DrivenSimulator if self.is_driven else Simulator
        rtol = FINE_RTOL if reads_generally(self.numeric.model) else RTOL
        return tuple(made(self.numeric, Direct(), Method(rtol=rtol, stiff=stiff)) for stiff in (False, True))

    @property
    def is_driven(self) -> bool:
        """Whether the orbit's delayed values are given to the simulation, not read from its past."""
        return self.delay.stages is not None

    def verify(self, orbit: Orbit, *, strict: bool = False) -> Verification:
        """Return whether an orbit is a motion of the model.

        One that lies so near to the border of what its signature can do that its error decides counts as one, unless
        ``strict``.
        """
        found = orbit.once("strict verification", lambda: self._verify(orbit, strict=True))
        if strict or found.verified == 1:
            return found
        return orbit.once("verification", lambda: self._excuse(orbit, self._verify(orbit, strict=False)))

    @staticmethod
    def _excuse(orbit: Orbit, found: Verification) -> Verification:
        """Return what was found, or that an orbit is a motion which drifts no farther than its estimated error allows.

        That counts what intervals pass on to others, through the whole period, and costs more than what each leaves.
        """
        if found.reason.code != DRIFTS:
            return found
        # Free parameters count relative to their own values: their ranges are not known here.
        error = estimate_error(orbit, tuple(np.where(orbit.free != 0.0, np.abs(orbit.free), 1.0).tolist()))
        allowed = ESTIMATED * error if np.isfinite(error) else 0.0
        return Verification(1, found.deviation) if found.deviation <= allowed else found

    def _verify(self, orbit: Orbit, *, strict: bool) -> Verification:
        if not np.all(orbit.durations > find_instants(orbit)) or not orbit.period > 0.0:
            return Verification(0, reason=make_reason("no_time"))
        examined = Examination(orbit, self.simulators, self.is_driven)
        found: list[Verification] = []
        for place in PLACES:
            # All windows begin at the same place, so that together they hold the whole orbit.
            found.append(_judge_all(examined, place, strict=strict))
            if found[-1].verified == 1:
                return found[-1]
        return next((verification for verification in found if verification.verified == 0), found[0])


def _judge_all(examined: Examination, place: float, *, strict: bool) -> Verification:
    """Return whether the motion goes on as the orbit does from a place in each segment to that in the next one."""
    deviations, undone = [], None
    for window in examined.list_windows(place):
        found = judge(examined, window, examined.simulate(window), strict=strict)
        if found.verified == 0:
            return found
        undone = found if found.verified < 0 else undone
        deviations.append(found.deviation)
    # Of an orbit at a border the deviation is not known.
    return undone or Verification(1, float(np.max(deviations)))
