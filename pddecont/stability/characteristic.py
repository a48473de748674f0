"""The characteristic matrix of an orbit: as large as one period, however long the delays.

A perturbation that is mu times as large a period later obeys the linearised equations of one period

    M(z) X = (A_0 + z A_1 + z^2 A_2 + ...) X = 0,      z = 1/mu

with A_w what stands for unknowns of w periods ago (``stability.monodromy``). Its determinant is an entire function of
z, and det M(z) / det M(0) is the product of 1 - z mu over all multipliers mu. Nothing of a long history is left in it
but powers of z, so that it is as well conditioned as the orbit itself; the map from history to history is not.

Reference: Szalai, Stepan, Hogan, SIAM J. Sci. Comput. 28 (2006); Sieber, Szalai, SIAM J. Appl. Dyn. Syst. 10 (2011).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.continuation import Matrix, is_odd, row_maxima, scale_matrix
from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Ints = NDArray[np.intp]


Solve: TypeAlias = Callable[[Complex], Complex]


@dataclass(frozen=True, eq=False)
class Factors:
    """The factors of M(z), its rows multiplied by ``rows``, the inverses of their sizes.

    ``matrix`` is M so scaled; ``solve`` and ``solve_adjoint`` solve with it and its conjugate transpose. ``diagonal``
    is that of the upper factor, ``permutations`` those of rows and columns.
    """

    matrix: Matrix
    rows: Array
    solve: Solve
    solve_adjoint: Solve
    diagonal: Callable[[], Complex]
    permutations: tuple[Ints, ...]

    @cached_property
    def log_determinant(self) -> complex:
        """The logarithm of the determinant of M itself, its imaginary part up to whole turns."""
        odd = sum(map(is_odd, self.permutations)) % 2
        logarithm = np.sum(np.log(self.diagonal().astype(complex))) - np.sum(np.log(self.rows))
        return complex(logarithm) + 1j * np.pi * odd


class Characteristic(Protocol):
    """A matrix function M(z) whose determinant is zero at the inverse of each multiplier."""

    @property
    def size(self) -> int:
        """Number of rows."""
        ...

    @property
    def depth(self) -> int:
        """How many periods back the equations reach: the highest power of z."""
        ...

    def matrix(self, z: complex) -> Matrix:
        """Return M(z)."""
        ...

    def derivative(self, z: complex) -> Matrix:
        """Return dM/dz."""
        ...

    def row_sizes(self, z: complex) -> Array:
        """Return the largest entry of each row (n_rows,), were all terms of an entry of one sign; 1 for a row of 0."""
        ...


@dataclass(frozen=True, eq=False)
class PeriodCharacteristic:
    """The sparse characteristic matrix of one period from its entries.

    Entry i stands at ``rows[i]``, ``columns[i]`` and is ``values[i]`` z^``powers[i]``.
    """

    size: int
    rows: Ints
    columns: Ints
    powers: Ints
    values: Array

    @cached_property
    def _places(self) -> tuple[Ints, Ints, Ints, Ints]:
        """Order of the entries by column and row, where each place begins in it, and the rows and column ends."""
        key = self.columns * self.size + self.rows
        order = np.argsort(key, kind="stable")
        ordered = key[order]
        first = np.flatnonzero(np.diff(ordered, prepend=-1))
        ends = np.searchsorted(ordered[first], np.arange(self.size + 1) * self.size)
        return order, first, (ordered[first] % self.size).astype(np.intc), ends.astype(np.intc)

    def _fill(self, values: NDArray[Any]) -> Matrix:
        order, first, rows, ends = self._places
        return sp.csc_matrix((np.add.reduceat(values[order], first), rows, ends), shape=(self.size, self.size))

    @cached_property
    def depth(self) -> int:
        """How many periods back the equations reach."""
        return int(np.max(self.powers, initial=0))

    @cached_property
    def _exponents(self) -> Ints:
        return np.arange(self.depth + 1)

    def matrix(self, z: complex) -> Matrix:
        """Return M(z), real where z is."""
        return self._fill(self.values * (_simplify(z) ** self._exponents)[self.powers])

    def derivative(self, z: complex) -> Matrix:
        """Return dM/dz, with the places of M."""
        slopes = self._exponents * _simplify(z) ** np.maximum(self._exponents - 1, 0)
        return self._fill(self.values * slopes[self.powers])

    def row_sizes(self, z: complex) -> Array:
        """Return the largest entry of each row of M(z), were all its terms of one sign."""
        return row_maxima(self._fill(np.abs(self.values) * (abs(z) ** self._exponents)[self.powers]))


@dataclass(frozen=True, eq=False)
class MapCharacteristic:
    """I - z times the map from history to history: for histories that are states of delay lines."""

    map: Array
    depth: int = 1

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.map)

    def matrix(self, z: complex) -> Matrix:
        """Return I - z map."""
        return np.eye(self.size) - _simplify(z) * self.map

    def derivative(self, z: complex) -> Matrix:
        """Return minus the map."""
        return -self.map

    def row_sizes(self, z: complex) -> Array:
        """Return the largest entry of each row of I + |z| |map|."""
        return row_maxima(np.eye(self.size) + abs(z) * np.abs(self.map))


def _simplify(z: complex) -> complex | float:
    return z if z.imag else z.real


def factor_at(characteristic: Characteristic, z: complex) -> Factors:
    """Return the factors of M(z).

    Raises
    ------
    ConvergenceError
        If it is singular to the last bit, or not finite.
    """
    with np.errstate(all="ignore"):
        matrix = characteristic.matrix(z)
    if not np.all(np.isfinite(matrix.data if sp.issparse(matrix) else matrix)):
        raise ConvergenceError("the characteristic matrix is not finite")
    rows = 1.0 / characteristic.row_sizes(z)
    matrix = scale_matrix(matrix, rows, np.ones(characteristic.size))
    return _factor_sparse(matrix, rows) if sp.issparse(matrix) else _factor_dense(matrix, rows)


def _factor_sparse(matrix: Matrix, rows: Array) -> Factors:
    try:
        lu = scipy.sparse.linalg.splu(matrix)
    except RuntimeError as exc:
        raise ConvergenceError("the characteristic matrix is singular") from exc

    def solve_adjoint(b: Complex) -> Complex:
        return np.asarray(lu.solve(b, "H"))

    return Factors(matrix, rows, lu.solve, solve_adjoint, lambda: lu.U.diagonal(), (lu.perm_r, lu.perm_c))


def _factor_dense(matrix: Matrix, rows: Array) -> Factors:
    with warnings.catch_warnings():
        warnings.simplefilter("error", scipy.linalg.LinAlgWarning)
        try:
            lu, pivots = scipy.linalg.lu_factor(matrix, check_finite=False)
        except (scipy.linalg.LinAlgWarning, scipy.linalg.LinAlgError) as exc:
            raise ConvergenceError("the characteristic matrix is singular") from exc
    permutation = np.arange(len(pivots))
    for i, k in enumerate(pivots.tolist()):
        permutation[[i, k]] = permutation[[k, i]]

    def solve(b: Complex) -> Complex:
        return np.asarray(scipy.linalg.lu_solve((lu, pivots), b, check_finite=False))

    def solve_adjoint(b: Complex) -> Complex:
        return np.asarray(scipy.linalg.lu_solve((lu, pivots), b, trans=2, check_finite=False))

    return Factors(matrix, rows, solve, solve_adjoint, lambda: np.diag(lu), (permutation,))
