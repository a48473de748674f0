"""Linear terms that read the past through integrals.

    K(lambda) = integral of k(s) exp(-lambda s) ds over lags s from low to high

for each entry of a matrix that is not zero: what x(t) = q exp(lambda t) gives is K(lambda) q exp(lambda t).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.quadrature import Kernel, make_points
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Ints = NDArray[np.intp]
# Exponentials that are made at a time.
MADE = 1_000_000


@dataclass(frozen=True, eq=False)
class DistributedTerm:
    """Entries of a matrix in ``rows`` and ``columns`` (n_entries,), all over the same lags.

    ``kernel`` returns their k at lags (n_points,), shape (n_entries, n_points); ``panels`` are the edges of panels that
    resolve it, the first one the lower limit and the last one the upper one.
    """

    rows: Ints
    columns: Ints
    kernel: Kernel
    panels: Array

    @property
    def longest(self) -> float:
        """The longest lag."""
        return float(max(self.panels[0], self.panels[-1]))

    def transform(self, roots: Complex | complex) -> tuple[Complex, Complex]:
        """Return K and its derivative in lambda at ``roots`` of any shape, (*shape, n_entries) each.

        Where an exponential overflows they are not finite.
        """
        given = np.asarray(roots, dtype=complex)
        flat = given.ravel()
        points, weights = make_points(self.panels, float(np.max(np.abs(flat), initial=0.0)))
        weighted = (self.kernel(points) * weights).T
        both = np.hstack([weighted, -points[:, None] * weighted])
        with np.errstate(over="ignore", invalid="ignore"):
            pieces = np.array_split(flat, 1 + len(flat) * len(points) // MADE)
            found = np.concatenate([np.exp(-piece[:, None] * points) @ both for piece in pieces])
        values, slopes = np.split(found.reshape(*given.shape, both.shape[1]), 2, axis=-1)
        return values, slopes

    @cached_property
    def sizes(self) -> Array:
        """The integrals of |k| (n_entries,), from above by Schwarz's inequality on each panel."""
        points, weights = make_points(self.panels)
        widths = np.abs(np.diff(self.panels))
        squares = np.sum((self.kernel(points) ** 2 * np.abs(weights)).reshape(len(self.rows), len(widths), -1), axis=2)
        return np.asarray(np.sum(np.sqrt(squares * widths), axis=1))

    def project(self, reads: Kernel, rate: float) -> Array:
        """Return the integrals of k times functions whose values ``reads`` returns, shape (n_entries, n_functions).

        The functions (n_functions, n_points) change as exponentials exp(-lambda s) with |lambda| = ``rate`` do.
        """
        points, weights = make_points(self.panels, rate)
        return np.asarray((self.kernel(points) * weights) @ reads(points).T)

    def transpose(self) -> DistributedTerm:
        """Return the term with rows and columns exchanged."""
        return replace(self, rows=self.columns, columns=self.rows)
