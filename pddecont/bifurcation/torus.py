"""Torus (TR): a pair of complex multipliers crosses the unit circle.

On a curve in two parameters the condition is that the product of the pair is 1. Product and sum of the pair are smooth even where
it meets on the real axis, which ends the curve: at a sum of 2 (resonance 1:1) or -2 (1:2). On the way -1 is 1:3 and 0 is 1:4.

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapter 9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.curve import Curve
from pddecont.stability.multipliers import Known, Multipliers

Array = NDArray[np.float64]
KIND = "TR"


def passing(m: Multipliers) -> float:
    """Return the distance to the unit circle of the complex pair nearest to it, signed by the parity of pairs outside."""
    upper = np.abs(m.own[m.own.imag > 0.0])
    if not len(upper):
        return float("nan")
    return float((-1.0) ** np.sum(upper > 1.0) * np.min(np.abs(upper - 1.0)))


@dataclass(frozen=True, eq=False)
class Torus:
    """The condition that the product of a pair of multipliers is 1; ``near`` is where the pair's upper one was."""

    known: Known
    near: complex
    kind: str = KIND

    def pair(self, curve: Curve, x: Array) -> tuple[complex, complex]:
        """Return the two multipliers."""
        own = self.known(curve.problem, x).own
        if len(own) < 2:
            return complex("nan"), complex("nan")
        i = int(np.argmin(np.abs(own - self.near)))
        j = int(np.argmin(np.where(np.arange(len(own)) == i, np.inf, np.abs(own - np.conj(self.near)))))
        return complex(own[i]), complex(own[j])

    def value(self, curve: Curve, x: Array) -> float:
        """Return product - 1."""
        a, b = self.pair(curve, x)
        return float((a * b).real - 1.0)

    def sum(self, curve: Curve, x: Array) -> float:
        """Return the sum of the pair, 2 cos(angle) on the curve."""
        a, b = self.pair(curve, x)
        return float((a + b).real)

    def framed(self, curve: Curve, x: Array) -> Torus:
        """Return the same condition with the pair looked for where it is at ``x``."""
        a, b = self.pair(curve, x)
        upper = a if a.imag >= b.imag else b
        return Torus(self.known, upper)
