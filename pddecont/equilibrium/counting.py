"""How many characteristic roots lie to the right of the imaginary axis beside those of a list.

The quotient of det Delta(lambda) and prod_k (lambda - lambda_k) over the roots of a list has the others as its zeros.
Multiplied by prod_k (lambda + c_k) / prod_j (lambda + d_j), whose factors have no zeros to the right, it is a function
Q that tends to one far away. By the argument principle

    zeros to the right = -(change of arg Q(i omega) from omega = 0 to infinity) / pi

Roots of the list may lie on the axis or next to it: in Q they are gone. The c_k and d_j are near what they divide in
size, so that Q changes little.

Reference: Stepan, Retarded Dynamical Systems (1989), section 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.characteristic import ENTRIES, CharacteristicMatrix

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Points on the axis at first, and as many more for each turn of an exponential.
FEW, PER_TURN = 33, 6
# Beyond this many times the bound of roots the argument of Q changes by what closed form says.
FAR = 2.0
# Between neighbours the logarithm of Q changes by less than this, and by less than twice that at the rates of both: a
# whole turn between them would pass unnoticed. Else a point is put between them.
CHANGE = 0.7
# Points at most, of small matrices and of sparse ones; a step over which rates are taken, as a part of the whole way.
MAX_POINTS, MAX_SPARSE, STEP = 200_000, 20_000, 1e-8
# How far to the right of the axis Q is taken, as a part of the whole way: a root on the axis is no zero to divide by.
ASIDE = 1e-7
# Neighbours nearer than this part of the whole way: the axis goes through a root that is not in the list.
NEAREST = 1e-12
# The least point beside zero, as a part of the whole way; and places where a root may be, at most.
LEAST, MANY = 1e-6, 40
# Terms of the series for what is left beyond: each is at most half of the one before.
TERMS = 12


@dataclass(frozen=True, eq=False)
class Count:
    """What the argument of Q says: how many roots to the right a list lacks, and about where they are (n_places,).

    ``number`` is None where a root that is not in the list lies on the axis.
    """

    number: int | None
    places: Complex


def count_missing(matrix: CharacteristicMatrix, listed: Complex) -> Count:
    """Return how many roots to the right of the imaginary axis a list lacks.

    ``listed`` holds both of each conjugate pair.
    """
    if matrix.bound == 0.0:
        # No term is left but lambda I: no root lies to the right of zero.
        return Count(0, np.zeros(0, dtype=complex))
    longest = matrix.longest
    end = FAR * max(matrix.bound, float(np.max(np.abs(listed), initial=0.0)), np.finfo(float).tiny)
    # Above a height delayed terms are too small to turn the determinant.
    turning = min(end, max(matrix.height + 2.0 * matrix.reach, LEAST * end))
    if not PER_TURN * turning * longest / (2.0 * np.pi) < MAX_POINTS:
        return Count(None, np.zeros(0, dtype=complex))
    n_points = FEW + int(PER_TURN * turning * longest / (2.0 * np.pi))
    # Roots near zero need points near zero: others are spaced evenly.
    omega = np.union1d(np.linspace(0.0, turning, n_points), np.geomspace(LEAST * turning, end, FEW))
    most = MAX_SPARSE if matrix.is_sparse else MAX_POINTS
    factors = _find_factors(matrix, end, listed)
    values, rates = _find_log_quotients(matrix, end, omega, factors)
    while True:
        change, gaps = np.diff(values), np.diff(omega)
        turns = np.angle(np.exp(1j * change.imag))
        expected = gaps * np.maximum(rates[1:], rates[:-1])
        rough = (np.hypot(change.real, turns) >= CHANGE) | (expected >= 2.0 * CHANGE)
        if not np.any(rough):
            break
        if np.min(gaps[rough]) < NEAREST * end:
            return Count(None, 1j * omega[:-1][rough])
        if len(omega) + float(np.sum(expected[rough])) > most:
            return Count(None, np.zeros(0, dtype=complex))
        where = np.flatnonzero(rough) + 1
        between = (0.5 * (omega[:-1] + omega[1:]))[rough]
        added = _find_log_quotients(matrix, end, between, factors)
        omega = np.insert(omega, where, between)
        values, rates = (np.insert(old, where, new) for old, new in zip((values, rates), added, strict=True))
    number = round(-(float(np.sum(turns)) + _find_rest(matrix, end, factors)) / np.pi)
    return Count(number, _find_places(omega, turns) if number > 0 else np.zeros(0, dtype=complex))


def _find_places(omega: Array, turns: Array) -> Complex:
    """Return where roots to the right make the argument fall: by a / (a^2 + (omega - b)^2) for the root a + i b."""
    rates, middles = turns / np.diff(omega), 0.5 * (omega[:-1] + omega[1:])
    padded = np.concatenate([[np.inf], rates, [np.inf]])
    lowest = np.flatnonzero((rates < 0.0) & (rates <= padded[:-2]) & (rates <= padded[2:]))
    lowest = lowest[np.argsort(rates[lowest])][:MANY]
    return np.asarray(-1.0 / rates[lowest] + 1j * middles[lowest])


def _find_factors(matrix: CharacteristicMatrix, end: float, listed: Complex) -> tuple[Complex, Array]:
    """Return the numbers z_k of the factors lambda - z_k of Q beside the determinant, and their powers, 1 or -1."""
    rows = np.asarray(abs(matrix.present).sum(axis=1), dtype=float).ravel()
    own = np.where(rows > LEAST * end, rows, max(matrix.reach, LEAST * end))
    beside = -np.maximum(np.abs(listed), LEAST * end)
    return np.concatenate([listed, beside, -own]), np.repeat([-1.0, 1.0, -1.0], [len(listed), len(listed), len(own)])


def _find_log_quotients(
    matrix: CharacteristicMatrix, end: float, omega: Array, factors: tuple[Complex, Array]
) -> tuple[Complex, Array]:
    """Return log Q next to i omega (n,), imaginary parts up to whole turns, and the moduli of its rates of change."""
    step, (zeros, powers) = STEP * end, factors
    points: Complex = np.asarray(ASIDE * end + 1j * np.append(omega, omega + step), dtype=np.complex128)
    values = matrix.log_determinants(points)
    for piece in np.array_split(np.arange(len(points)), 1 + len(points) * len(zeros) // ENTRIES):
        values[piece] += np.log(points[piece][:, None] - zeros) @ powers
    here, ahead = values[: len(omega)], values[len(omega) :]
    turn = np.angle(np.exp(1j * (ahead - here).imag))
    return here, np.hypot((ahead - here).real, turn) / step


def _find_rest(matrix: CharacteristicMatrix, end: float, factors: tuple[Complex, Array]) -> float:
    """Return by how much the argument of Q changes from i ``end`` to infinity.

    Delta(lambda) = lambda (I - S / lambda): log det(I - S / lambda) is small there, and zero at infinity.
    """
    at, (zeros, powers) = 1j * end, factors
    # The logarithm of the determinant less that of lambda^n, on the branch that is zero at infinity.
    own = complex(matrix.log_determinants(np.array([at]))[0] - matrix.n * np.log(at))
    near = own.imag - 2.0 * np.pi * round((own.imag - _guess_rest(matrix, at)) / (2.0 * np.pi))
    return -near - float(np.log(1.0 - zeros / at).imag @ powers)


def _guess_rest(matrix: CharacteristicMatrix, at: complex) -> float:
    """Return the argument of det(I - S / lambda) by the series -tr(S / lambda) - tr(S^2 / lambda^2) / 2 - ..."""
    scaled = matrix.unit - matrix.at(at)[0] / at
    if not matrix.is_sparse:
        return float(np.sum(np.log(1.0 - np.linalg.eigvals(scaled)).imag))
    power, total = scaled, 0.0
    for k in range(1, TERMS + 1):
        total -= complex(power.diagonal().sum()).imag / k
        power = power @ scaled
    return total
