"""Eigenvalues of a large discretised equation: those around points of the imaginary axis, by Arnoldi's method.

Around each point all eigenvalues within a radius are found. Points are added until the discs cover the axis as far up
as an unstable root can lie; what lies deep to the right between two discs is left to the count (``counting``).

Reference: Meerbergen, Spence, Roose, BIT 34 (1994); Lehoucq, Sorensen, Yang, ARPACK Users' Guide (1998).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.equilibrium.generator import Generator

Complex = NDArray[np.complex128]
# First guesses of roots (n_guesses,), and their vectors (n_guesses, n_states).
Guesses = tuple[Complex, Complex]
# Eigenvalues found around a point, and vectors kept for that; more of both where eigenvalues lie close.
AROUND, KEPT = 40, 160
# How exact they are: only guesses are wanted.
ROUGH = 1e-6
# Points at most, how far to the right of the axis they lie as a part of its length, and how much of a radius counts.
STATIONS, OFF_AXIS, SURE = 60, 1e-4, 0.8
# An eigenvalue nearer than this part of the axis to one that was found around another point is the same.
MERGE = 1e-5


def find_along_axis(generator: Generator, height: float) -> Guesses:
    """Return the eigenvalues around the imaginary axis from zero to i ``height``."""
    values, vectors = np.zeros(0, dtype=complex), np.zeros((0, generator.matrix.n), dtype=complex)
    gaps = [(0.0, height)]
    for _ in range(STATIONS):
        if not gaps:
            break
        low, high = gaps.pop(int(np.argmax([b - a for a, b in gaps])))
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        radius, (around, own) = find_around(generator, complex(OFF_AXIS * height, middle))
        new = np.min(np.abs(around[:, None] - values), axis=1, initial=np.inf) > MERGE * height
        values, vectors = np.concatenate([values, around[new]]), np.concatenate([vectors, own[new]])
        sure = SURE * radius
        if 0.0 < sure < half:
            gaps += [(low, middle - sure), (middle + sure, high)]
    return values, vectors


def find_around(generator: Generator, shift: complex) -> tuple[float, Guesses]:
    """Return a radius around a point, and all eigenvalues within it; zero where it is not known."""
    n, size = generator.matrix.n, generator.size
    start = np.random.default_rng(0).normal(size=size).astype(complex)
    k, kept = min(AROUND, size - 2), min(KEPT, size)
    try:
        around, vectors = scipy.sparse.linalg.eigs(generator.invert_shifted(shift), k=k, ncv=kept, v0=start, tol=ROUGH)
        radius = float(1.0 / np.min(np.abs(around)))
    except scipy.sparse.linalg.ArpackNoConvergence as exc:
        around, vectors, radius = exc.eigenvalues, exc.eigenvectors, 0.0
    own = vectors[:n].T
    return radius, (np.asarray(shift + 1.0 / around), own / np.linalg.norm(own, axis=1, keepdims=True))
