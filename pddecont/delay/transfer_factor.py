"""What a delay does to an exponential: the delayed value of exp(lambda t) is H(lambda tau) exp(lambda t).

The delay itself has H(s) = exp(-s). A delay line of n equal stages, mass y' = (A y + B q) / delta with delta = tau / n,
has H(s) = G(s / n)^n with G(z) = e_out . (z mass - A)^-1 B.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.interface import DelayMethod, LineStages

Complex = NDArray[np.complex128]


def find_transfer_factor(method: DelayMethod, s: Complex | complex) -> tuple[Complex, Complex]:
    """Return H and its derivative at s = lambda tau, of any shape, for a way to discretise the delay."""
    stages, s = method.stages, np.asarray(s, dtype=complex)
    with np.errstate(over="ignore", invalid="ignore"):
        if stages is None:
            factor: Complex = np.exp(-s)
            return factor, -factor
        one, slope = _pass_stage(stages, s / stages.n)
        power = one ** (stages.n - 1)
        return np.asarray(power * one, dtype=complex), np.asarray(power * slope, dtype=complex)


def _pass_stage(stages: LineStages, z: Complex) -> tuple[Complex, Complex]:
    """Return G and its derivative at z = lambda delta."""
    line = stages.line
    matrix = z[..., None, None] * np.diag(line.mass) - line.A
    states = np.linalg.solve(matrix, line.B[:, None])
    slopes = -np.linalg.solve(matrix, line.mass[:, None] * states)
    return np.asarray(states[..., line.out, 0], dtype=complex), np.asarray(slopes[..., line.out, 0], dtype=complex)
