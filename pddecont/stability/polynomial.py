"""The multipliers of an orbit without memory beside its states, however far apart: zeros of a polynomial.

d(z) = det M(z) / det M(0) is the product of 1 - z mu over all multipliers. Where an orbit remembers no more than its
states that is a polynomial of no higher degree than there are states, and its values at as many points round a circle
|z| = 1 / r tell its coefficients. Where one of them, that of z^k, is larger on the circle than all others together,
just k multipliers lie outside |mu| = r (Pellet's theorem). Each multiplier is taken from a circle not far inside it,
where rounding of larger ones does not blur it.

Reference: Marden, Geometry of Polynomials (1966), section 28.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError
from pddecont.stability.characteristic import Characteristic, factor_at
from pddecont.stability.refinement import Refined, refine

Complex = NDArray[np.complex128]
# From one circle to the next radii grow by this factor, and the last is so much smaller than the leading multiplier.
FARTHER, BELOW = 1e4, 3.0
# A circle that goes by a multiplier is made smaller by this factor, so many times at most.
MOVED, MOVES = 0.6, 6
# What is left of a coefficient that is zero, relative to the largest, is rounding.
ROUNDING = 1e-9
# Where one lies too near to a circle they are asked for on one wider by this factor.
WIDER = 2.0
# A corrected multiplier is the one that was told if it is as near as this, relative to its size.
NEAR = 1e-4


def find_all_of_states(
    characteristic: Characteristic, most: int, candidates: Complex, radius: float, largest: float
) -> list[Refined] | None:
    """Return all multipliers of an orbit without memory outside |mu| = ``radius``; there are no more than ``most``.

    Where one lies near that circle it is those outside a wider one, of less than ``largest``. None where they are not
    told so. The first of the ``candidates`` (n,), by falling modulus, is the leading one to rounding.
    """
    leading, values = candidates[: 2 if candidates[0].imag else 1], None
    while values is None and radius < largest:
        try:
            values = find_outside(characteristic, most, radius, leading)
        except ConvergenceError:
            return None
        radius *= WIDER
    if values is None:
        return None
    found: list[Refined] = []
    for value in values[values.imag >= 0.0].tolist():
        one = refine(characteristic, value)
        if one is None or abs(one.value - value) > NEAR * abs(value):
            # Far larger ones, of 1e14 and more, are below rounding in the matrix: its determinant alone tells them.
            one = Refined(value, float("nan"), np.zeros(0, dtype=complex), True)
        found.append(one)
        if one.value.imag != 0.0:
            found.append(replace(one, value=one.value.conjugate()))
    return found


def find_outside(characteristic: Characteristic, most: int, radius: float, leading: Complex) -> Complex | None:
    """Return all multipliers outside |mu| = ``radius`` by falling modulus; there are no more than ``most``.

    ``leading`` holds the leading one, or pair: where it is far larger than 1e14, rounding hides d(0), and with it how
    large it is, but not by how much it exceeds the others.

    None where one lies too near to the circle, or the determinants do not tell.

    Raises
    ------
    ConvergenceError
        If the determinant is not defined on a circle.
    """
    found: list[complex] = []
    at_zero = factor_at(characteristic, 0.0).log_determinant
    series = _expand(characteristic, most, radius, at_zero)
    n_inside, inner, largest = _count(series), radius, float(np.abs(leading[0]))
    if n_inside is None or 0 < n_inside < len(leading):
        return None
    while n_inside > len(leading):
        outer, n_beyond = min(inner * FARTHER, largest / BELOW), None
        for _ in range(MOVES):
            if outer <= inner:
                return None
            following = _expand(characteristic, most, outer, at_zero)
            n_beyond = _count(following)
            if n_beyond is not None:
                break
            outer *= MOVED
        if (
            n_beyond is None
            or not len(leading) <= n_beyond <= n_inside
            or (n_beyond == n_inside and outer > largest / 9)
        ):
            return None
        zeros = np.roots(series[::-1])
        # Of those inside the circle |z| = 1 / inner the ones nearest to it are those that the next leaves out.
        zeros = zeros[np.argsort(-np.abs(zeros), kind="stable")]
        between = zeros[np.abs(zeros) < 1.0][: n_inside - n_beyond]
        found += np.conj(inner / between).tolist()
        inner, series, n_inside = outer, following, n_beyond
    values = np.array([*(leading.tolist() if n_inside else ()), *found], dtype=complex)
    return values[np.lexsort((-values.imag, -np.abs(values)))]


def _expand(characteristic: Characteristic, most: int, radius: float, at_zero: complex) -> NDArray[np.float64]:
    """Return the polynomial's coefficients times their powers of 1 / ``radius``, the largest about 1.

    ``at_zero`` is the logarithm of det M(0).
    """
    n = 2 * (most // 2 + 1)
    points = np.exp(1j * np.linspace(0.0, np.pi, n // 2 + 1)) / radius
    points[[0, -1]] = points[[0, -1]].real
    half = np.array([factor_at(characteristic, complex(z)).log_determinant - at_zero for z in points])
    scale = float(np.max(half.real))
    series = np.fft.irfft(np.conj(np.exp(half - scale)), n)
    # The first is known.
    series[0] = np.exp(-scale)
    return series


def _count(series: NDArray[np.float64]) -> int | None:
    """Return how many zeros lie inside the circle; None where the coefficients do not tell."""
    size = np.abs(series)
    k = int(np.argmax(size))
    return k if size[k] > (1.0 + ROUNDING) * (np.sum(size) - size[k]) else None
