"""How far back an orbit reads."""

from __future__ import annotations

import numpy as np

from pddecont.orbit.orbit import Orbit


def find_reach(orbit: Orbit) -> float:
    """Return the longest of an orbit's delays and of the lags that it integrates over, where equations hold."""
    reads, numeric, p = orbit.equation_reads, orbit.numeric, orbit.parameters
    longest = [float(np.max(numeric.delays.value(p), initial=0.0)), float(np.max(reads.lags, initial=0.0))]
    for number in range(len(numeric.model.integrals)):
        longest.append(float(np.max(numeric.limits(number).value(reads.t, reads.x, reads.xd, p)[1])))
    return max(longest)
