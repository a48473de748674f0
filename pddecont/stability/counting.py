"""How many multipliers lie outside a circle, by the argument principle, and where those are that a list lacks.

d(z) = det M(z) / det M(0) is the product of 1 - z mu over all multipliers; divided by that product over the multipliers
of a list, it is the product over those that the list lacks. As z goes once round the circle |z| = 1 / r that quotient
turns about zero once for each of them that lies outside |mu| = r, and less once for each that was listed and is none.
A complete list leaves it next to 1, which a few points tell.

Reference: Delves, Lyness, Math. Comp. 21 (1967).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError
from pddecont.stability.characteristic import Characteristic, factor_at

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Points on half the circle at first (the other half is its mirror image), and more for each further period of history:
# as many more times the determinant may turn.
FEW, MORE = 5, 4
# A circle on which the logarithm of the modulus of the quotient is farther from zero than this in the mean has zeros or
# poles inside; a count that says nothing of them needs twice the points, so many times at most.
MEAN, DOUBLINGS = 1.0, 8
# Between neighbours the logarithm of the quotient changes by less than this; else a point is put between them.
CHANGE = 0.7
# Neighbours nearer than this part of a turn: the circle goes through a zero.
NEAREST = 1e-7
# Points round the circle for finding zeros: at first, and at most.
MANY, MOST = 32, 2048
# Determinants that a count takes at most, and more for each further period of history: where rounding decides them, as
# with multipliers of 1e17 beside others, no number of them would do.
MOST_DETERMINANTS, MORE_DETERMINANTS = 2048, 32
# Coefficients of the quotient's power series below this part of the largest are rounding.
NEGLIGIBLE = 1e-11
# They are rounding too where twice the points leave more than this part of them, and what is no larger than so many
# times as much tells nothing; a series of which more than NOISY is rounding does not tell its zeros.
FALLS, ABOVE, NOISY = 0.1, 10.0, 1e-3
# Zeros of the power series beyond the circle are worth a try too, to where a history is this much larger, but not far.
BEYOND, FAR = 3.0, 1.3


@dataclass(eq=False)
class Counter:
    """Determinants of a characteristic matrix, each computed once."""

    characteristic: Characteristic
    _known: dict[complex, complex] = field(default_factory=dict)

    def log_quotient(self, z: complex, listed: Complex) -> complex:
        """Return the logarithm of d(z) over the product of 1 - z mu, its imaginary part up to whole turns."""
        own = self._log_determinant(z) - self._log_determinant(0.0)
        return own - complex(np.sum(np.log(1.0 - z * listed.astype(complex))))

    def _log_determinant(self, z: complex) -> complex:
        if z not in self._known:
            if len(self._known) >= MOST_DETERMINANTS + MORE_DETERMINANTS * self.characteristic.depth:
                raise ConvergenceError("the determinant does not tell how many multipliers there are")
            self._known[z] = factor_at(self.characteristic, z).log_determinant
        return self._known[z]

    def count_missing(self, listed: Complex, radius: float) -> int | None:
        """Return how many multipliers outside |mu| = ``radius`` a list lacks; None if the circle goes through one.

        Of more than six that are lacking it may count fewer, but never none.

        Raises
        ------
        ConvergenceError
            If the determinant is not defined on the circle, or does not tell.
        """
        angles = list(np.linspace(0.0, np.pi, FEW + MORE * max(0, self.characteristic.depth - 1)))
        for _ in range(DOUBLINGS):
            values = [self._at(angle, listed, radius) for angle in angles]
            turns = self._count_turns(angles, values, listed, radius)
            # By Jensen's formula the mean is the sum of log |mu| / radius over what the list lacks, less that over what
            # is none: where so many are lacking that whole turns between neighbours go unseen it is large.
            mean = float(np.trapezoid([value.real for value in values], angles)) / np.pi
            if turns is None or abs(mean) < MEAN or turns * mean > 0.0:
                return turns
            between = [0.5 * (a + b) for a, b in pairwise(angles)]
            angles = sorted([*angles, *between])
        return None

    def _count_turns(self, angles: list[float], values: list[complex], listed: Complex, radius: float) -> int | None:
        """Return how often the quotient turns about zero on half the circle; None if that goes through a zero.

        Points that this takes between others are put into ``angles`` and ``values``.
        """
        total, i = 0.0, 0
        while i + 1 < len(angles):
            change = values[i + 1] - values[i]
            turn = float(np.angle(np.exp(1j * change.imag)))
            if abs(complex(change.real, turn)) < CHANGE:
                total, i = total + turn, i + 1
                continue
            if angles[i + 1] - angles[i] < NEAREST:
                return None
            middle = 0.5 * (angles[i] + angles[i + 1])
            angles.insert(i + 1, middle)
            values.insert(i + 1, self._at(middle, listed, radius))
        return round(total / np.pi)

    def _at(self, angle: float, listed: Complex, radius: float) -> complex:
        point = complex(np.exp(1j * angle)) / radius
        return self.log_quotient(complex(point.real, 0.0) if angle in (0.0, np.pi) else point, listed)

    def find_missing(self, listed: Complex, radius: float) -> Complex:
        """Return where about multipliers outside |mu| = ``radius`` are that a list lacks.

        They are zeros of the quotient's power series, whose coefficients are real; of conjugate pairs the upper one is
        returned.

        Raises
        ------
        ConvergenceError
            If the determinant is not defined on the circle, or too small there to be known.
        """
        n, before = MANY, np.inf
        while True:
            half = [self._at(angle, listed, radius) for angle in np.linspace(0.0, np.pi, n // 2 + 1)]
            shift = max(value.real for value in half)
            values = np.exp(np.array(half) - shift)
            series = np.fft.irfft(np.conj(values), n)
            size = np.abs(series) / np.max(np.abs(series))
            tail = float(np.max(size[n // 2 :]))
            # The quotient is an entire function: with twice the points its last coefficients are far smaller, or noise.
            if tail <= NEGLIGIBLE or n >= MOST or (tail > FALLS * before and tail < NOISY):
                break
            n, before = 2 * n, tail
        if tail > NOISY:
            raise ConvergenceError("the determinant is not known well enough on this circle")
        large = np.flatnonzero(size > max(NEGLIGIBLE, ABOVE * tail))
        zeros = np.roots(series[: large[-1] + 1][::-1])
        beyond = min(FAR, BEYOND ** (1.0 / max(1, self.characteristic.depth)))
        zeros = zeros[(np.abs(zeros) < beyond) & (zeros.imag >= 0.0) & (zeros != 0.0)]
        found = np.conj(radius / zeros)
        return np.asarray(np.where(zeros.imag == 0.0, found.real, found), dtype=complex)
