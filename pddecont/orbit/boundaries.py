"""What a branch of orbits cannot pass: the ends of its parameters' ranges, delays of zero, segments that vanish."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
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


class AtUnknowns(Protocol):
    """An evaluation of equations whose last unknowns are the free parameters."""

    @property
    def x(self) -> Array:
        """The unknowns."""
        ...


@dataclass(frozen=True)
class RangeBoundary:
    """The parameters ``free``, the last unknowns, stay in their ``ranges``, (lowest, highest) each."""

    free: Sequence[str]
    ranges: Sequence[tuple[float, float]]
    approach: Approach = Approach.BEYOND
    end: str = End.RANGE

    def margins(self, at: AtUnknowns) -> Array:
        """Return the distance of each free parameter to each end of its range: all lower ends, all upper ends."""
        low, high = np.array(self.ranges).T
        values = at.x[-len(self.free) :]
        return np.concatenate([values - low, high - values])

    def gradients(self, at: AtUnknowns) -> Array:
        """Return their derivatives in the unknowns."""
        n = len(self.free)
        result = np.zeros((2 * n, len(at.x)))
        result[:n, -n:], result[n:, -n:] = np.eye(n), -np.eye(n)
        return result

    def reason(self, at: AtUnknowns, k: int) -> Reason:
        """Return which parameter reached which end."""
        i, upper = k % len(self.ranges), k >= len(self.ranges)
        return make_reason("range", parameter=self.free[i], value=self.ranges[i][upper])


@dataclass(frozen=True, eq=False)
class DelayBoundary:
    """Delays are not negative: no motion reads its future.

    The free parameters, numbered ``free``, are the last unknowns; the others have the values ``parameters``.
    """

    numeric: NumericModel
    parameters: Array
    free: tuple[int, ...]
    approach: Approach = Approach.UP_TO
    end: str = End.LIMIT

    def margins(self, at: AtUnknowns) -> Array:
        """Return the delays."""
        return self.numeric.delays.value(self._read(at))

    def gradients(self, at: AtUnknowns) -> Array:
        """Return their derivatives in the unknowns."""
        result = np.zeros((len(self.numeric.model.delays), len(at.x)))
        result[:, -len(self.free) :] = self.numeric.delays.derivatives(self._read(at), self.free)
        return result

    def reason(self, at: AtUnknowns, k: int) -> Reason:
        """Return which delay becomes negative, and at which free parameters."""
        delay, p, names = self.numeric.model.delays[k], self._read(at), list(self.numeric.model.parameters)
        held = {s.name for s in delay.free_symbols}
        values = {names[i]: float(p[i]) for i in self.free if names[i] in held}
        # A free parameter that is the delay itself is zero here, whatever rounding left.
        values |= {name: 0.0 for name in values if str(delay) == name}
        return make_reason(
            "negative_delay", delay=str(delay), **{f"at {name}": value for name, value in values.items()}
        )

    def _read(self, at: AtUnknowns) -> Array:
        p = self.parameters.copy()
        p[list(self.free)] = at.x[-len(self.free) :]
        return p


@dataclass(frozen=True, eq=False)
class VaryingDelayBoundary:
    """Delays that vary are not negative anywhere on an orbit, where its equations hold."""

    numeric: NumericModel
    approach: Approach = Approach.UP_TO
    end: str = End.LIMIT

    def margins(self, at: AtOrbit) -> Array:
        """Return the smallest value of each delay that varies, shape (n_varying,)."""
        return np.asarray(np.min(at.orbit.equation_reads.lags, axis=1))

    def gradients(self, at: AtOrbit) -> Array:
        """Return their derivatives in the unknowns; what a delay inside a delay reads counts as fixed."""
        orbit, reads = at.orbit, at.orbit.equation_reads
        unknowns, mesh, free = orbit.problem.unknowns, orbit.mesh, orbit.problem.free_index
        result = np.zeros((len(reads.lags), len(orbit.x)))
        for k, point in enumerate(np.argmin(reads.lags, axis=1).tolist()):
            function, here = self.numeric.varying_delay(k), [point]
            where = function.structure(free)
            d = function.derivatives(reads.t[here], reads.x[:, here], reads.xd[:, here], orbit.parameters, free)
            base = unknowns.value_index[mesh.base_index[mesh.equation_points.interval[point]]]
            weights = mesh.local_weights(mesh.equation_points)[point]
            for state, slope in zip(where.dx[1].tolist(), d.dx[:, 0], strict=True):
                result[k, base[:, state]] += slope * weights
            result[k, unknowns.free.start + where.dp[1]] += d.dp[:, 0]
            if len(where.dt):
                result[k, unknowns.start] += d.dt[0, 0]
                result[k, unknowns.durations] += d.dt[0, 0] * mesh.equation_times[point, : mesh.n_segments]
        return result

    def reason(self, at: AtOrbit, k: int) -> Reason:
        """Return which delay becomes negative, and at which free parameters."""
        orbit = at.orbit
        values = {f"at {name}": float(value) for name, value in zip(orbit.problem.free, orbit.free, strict=True)}
        return make_reason("negative_delay", delay=str(self.numeric.model.varying[k]), **values)


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
