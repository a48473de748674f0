"""What a delay does to an exponential: the delayed value of exp(lambda t) is H(lambda tau) exp(lambda t).

The delay itself has H(s) = exp(-s). A delay line of n equal stages, mass y' = (A y + B q) / delta with delta = tau / n,
has H(s) = G(s / n)^n with G(z) = e_out . (z mass - A)^-1 B.
"""

from __future__ import annotations

import cmath

import numpy as np

from pddecont.delay.interface import DelayMethod, LineStages


def find_transfer_factor(method: DelayMethod, s: complex) -> tuple[complex, complex]:
    """Return H and its derivative at s = lambda tau for a way to discretise the delay."""
    stages = method.stages
    if stages is None:
        factor = cmath.exp(-s)
        return factor, -factor
    one, slope = _pass_stage(stages, s / stages.n)
    return one**stages.n, one ** (stages.n - 1) * slope


def _pass_stage(stages: LineStages, z: complex) -> tuple[complex, complex]:
    """Return G and its derivative at z = lambda delta."""
    line = stages.line
    matrix = z * np.diag(line.mass) - line.A
    states = np.linalg.solve(matrix, line.B)
    slopes = -np.linalg.solve(matrix, line.mass * states)
    return complex(states[line.out]), complex(slopes[line.out])
