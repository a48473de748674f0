"""What a branch of orbits cannot pass: the ends of its parameters' ranges, delays of zero, segments that vanish."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import Approach, End
from pddecont.orbit.durations import find_instants, make_instant_matrix
from pddecont.orbit.orbit import Orbit
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]


class AtOrbit(Protocol):
    """An evaluation of equations that hold an orbit."""

    @property
    def orbit(self) -> Orbit:
        """The orbit."""
        ...


@dataclass(frozen=True)
class RangeBoundary:
    """The free parameters stay in their ``ranges``, (lowest, highest) each."""

    ranges: Sequence[tuple[float, float]]
    approach: Approach = Approach.BEYOND
    end: str = End.RANGE

    def margins(self, at: AtOrbit) -> Array:
        """Return the distance of each free parameter to each end of its range: all lower ends, all upper ends."""
        low, high = np.array(self.ranges).T
        return np.concatenate([at.orbit.free - low, high - at.orbit.free])

    def gradients(self, at: AtOrbit) -> Array:
        """Return their derivatives in the unknowns."""
        n, free = len(self.ranges), at.orbit.problem.unknowns.free
        result = np.zeros((2 * n, len(at.orbit.x)))
        result[:n, free], result[n:, free] = np.eye(n), -np.eye(n)
        return result

    def reason(self, at: AtOrbit, k: int) -> Reason:
        """Return which parameter reached which end."""
        i, upper = k % len(self.ranges), k >= len(self.ranges)
        return make_reason("range", parameter=at.orbit.problem.free[i], value=self.ranges[i][upper])


@dataclass(frozen=True)
class DelayBoundary:
    """Delays are not negative: no motion reads its future."""

    approach: Approach = Approach.UP_TO
    end: str = End.LIMIT

    def margins(self, at: AtOrbit) -> Array:
        """Return the delays."""
        return at.orbit.numeric.delays.value(at.orbit.parameters)

    def gradients(self, at: AtOrbit) -> Array:
        """Return their derivatives in the unknowns."""
        orbit = at.orbit
        result = np.zeros((len(orbit.numeric.model.delays), len(orbit.x)))
        result[:, orbit.problem.unknowns.free] = orbit.numeric.delays.derivatives(
            orbit.parameters, orbit.problem.free_index
        )
        return result

    def reason(self, at: AtOrbit, k: int) -> Reason:
        """Return which delay becomes negative, and at which free parameters."""
        orbit = at.orbit
        delay = orbit.numeric.model.delays[k]
        held = {s.name for s in delay.free_symbols}
        values = {
            name: value for name, value in zip(orbit.problem.free, orbit.free.tolist(), strict=True) if name in held
        }
        # A free parameter that is the delay itself is zero here, whatever rounding left.
        values |= {name: 0.0 for name in values if str(delay) == name}
        return make_reason(
            "negative_delay", delay=str(delay), **{f"at {name}": value for name, value in values.items()}
        )


@dataclass(frozen=True)
class DurationBoundary:
    """Segments last longer than rounding: an orbit has no equations with a segment of no duration."""

    approach: Approach = Approach.TOWARDS
    end: str = End.IMPOSSIBLE

    def margins(self, at: AtOrbit) -> Array:
        """Return by how much each segment's duration exceeds rounding."""
        return at.orbit.durations - find_instants(at.orbit)

    def gradients(self, at: AtOrbit) -> Array:
        """Return their derivatives in the unknowns."""
        durations = at.orbit.problem.unknowns.durations
        n = durations.stop - durations.start
        result = np.zeros((n, len(at.orbit.x)))
        result[:, durations] = np.eye(n) - make_instant_matrix(at.orbit.signature)
        return result

    def reason(self, at: AtOrbit, k: int) -> Reason:
        """Return which segment vanishes."""
        return make_reason("segment_vanishes", number=k + 1, segment=at.orbit.signature.names[k])
