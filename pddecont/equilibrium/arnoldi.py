"""Eigenvalues of a large discretised equation: those farthest to the right, by Arnoldi's method.

Around a point all eigenvalues within a radius are found. Points are added until the discs cover the rectangle in which
unstable roots can lie; then it grows to the left until there are enough.

Reference: Meerbergen, Spence, Roose, BIT 34 (1994); Lehoucq, Sorensen, Yang, ARPACK Users' Guide (1998).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import find_largest
from pddecont.equilibrium.generator import Generator

Complex = NDArray[np.complex128]
# First guesses of roots (n_guesses,), and their vectors (n_guesses, n_states).
Guesses = tuple[Complex, Complex]
# Eigenvalues found around a point, and vectors kept for that.
AROUND, KEPT = 40, 160
# How exact they are: only guesses are wanted.
ROUGH = 1e-6
# Points at most, and how far to the left of the axis is looked at first, as a part of the region's height or width.
STATIONS, MARGIN = 60, 0.05
# Eigenvalues nearer than this part of the region to one that was found around another point are the same, and one that
# near to the real axis is real.
MERGE = 1e-5


@dataclass(frozen=True)
class Box:
    """A rectangle of the complex plane with two sides parallel to the real axis."""

    low: complex
    high: complex

    @property
    def middle(self) -> complex:
        """Its middle."""
        return 0.5 * (self.low + self.high)

    @property
    def radius(self) -> float:
        """Half of its diagonal."""
        return 0.5 * abs(self.high - self.low)

    def split(self) -> tuple[Box, Box]:
        """Return its halves: the longer sides are cut."""
        size, at = self.high - self.low, self.middle
        if size.real > size.imag:
            return Box(self.low, complex(at.real, self.high.imag)), Box(complex(at.real, self.low.imag), self.high)
        return Box(self.low, complex(self.high.real, at.imag)), Box(complex(self.low.real, at.imag), self.high)


def find_rightmost(generator: Generator, n_roots: int, most: float) -> Guesses:
    """Return all eigenvalues right of the axis in the upper half-plane, or next to it; ``n_roots`` at least.

    ``most`` is what unstable ones do not exceed in modulus.
    """
    matrix = generator.matrix
    abscissa, height = min(matrix.abscissa, most), min(matrix.height, most)
    size = max(abscissa, height)
    margin = MARGIN * size
    boxes = [Box(complex(-margin, 0.0), complex(abscissa, height))]
    values, vectors = np.zeros(0, dtype=complex), np.zeros((0, matrix.n), dtype=complex)
    for _ in range(STATIONS):
        if not boxes:
            if np.sum((values.real > -margin) & (values.imag >= 0.0)) >= min(n_roots, matrix.n):
                break
            # The region grows to the left.
            boxes.append(Box(complex(-2.0 * margin, 0.0), complex(-margin, height)))
            margin *= 2.0
        box = boxes.pop(int(np.argmax([one.radius for one in boxes])))
        radius, (around, own) = find_around(generator, box.middle)
        new = np.min(np.abs(around[:, None] - values), axis=1, initial=np.inf) > MERGE * size
        values, vectors = np.concatenate([values, around[new]]), np.concatenate([vectors, own[new]])
        if radius < box.radius:
            boxes += box.split()
    return np.where(np.abs(values.imag) < MERGE * size, values.real, values), vectors


def find_around(generator: Generator, shift: complex) -> tuple[float, Guesses]:
    """Return a radius around a point, and all eigenvalues within it; zero where it is not known."""
    n, size = generator.matrix.n, generator.size
    start = np.random.default_rng(0).normal(size=size).astype(complex)
    k, kept = min(AROUND, size - 2), min(KEPT, size)
    around, vectors, is_known = find_largest(generator.invert_shifted(shift), k, n_vectors=kept, start=start, tol=ROUGH)
    radius = float(1.0 / np.min(np.abs(around))) if is_known else 0.0
    own = vectors[:n].T
    return radius, (np.asarray(shift + 1.0 / around), own / np.linalg.norm(own, axis=1, keepdims=True))
