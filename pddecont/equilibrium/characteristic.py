"""The characteristic matrix of an equilibrium, whose singular values of lambda are its characteristic roots."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.continuation import find_log_determinant
from pddecont.delay import DelayMethod, find_transfer_factor

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Matrices of more rows are sparse.
DENSE = 120
# Rounds in which the bound of roots is made smaller.
QUOTIENTS = 30


@dataclass(frozen=True, eq=False)
class CharacteristicMatrix:
    """Delta(lambda) = lambda I - A_0 - sum_k A_k lambda^m_k H(lambda tau_k), H what the method does to exponentials.

    ``present`` A_0 has shape (n, n), ``delayed`` A_k that shape for each term, ``delays`` tau_k shape (n_terms,).
    ``orders`` m_k say how often a state is differentiated where it is read (None: never).
    Matrices are arrays, or sparse in CSC form. Reference: Hale, Verduyn Lunel, Introduction to Functional Differential
    Equations (1993), chapter 7.
    """

    present: Any
    delayed: tuple[Any, ...]
    delays: Array
    method: DelayMethod
    orders: NDArray[np.intp] | None = None

    @property
    def is_neutral(self) -> bool:
        """Whether past rates are read."""
        return self.orders is not None and bool(np.any(self.orders > 0))

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.present.shape[0])

    @property
    def is_sparse(self) -> bool:
        """Whether the matrices are sparse."""
        return bool(sp.issparse(self.present))

    @cached_property
    def unit(self) -> Any:
        """The unit matrix."""
        return sp.eye(self.n, format="csc") if self.is_sparse else np.eye(self.n)

    def at(self, root: complex) -> tuple[Any, Any]:
        """Return Delta and its derivative in lambda, shape (n, n) each."""
        matrix, slope = root * self.unit - self.present, self.unit.astype(complex)
        for through, (factor, rate) in zip(self.delayed, self.list_factors(root), strict=True):
            matrix = matrix - complex(factor) * through
            slope = slope - complex(rate) * through
        return matrix, slope

    def at_many(self, roots: Complex) -> tuple[Complex, Complex]:
        """Return the same at several points, shape (n_roots, n, n) each; of dense matrices."""
        matrix = roots[:, None, None] * self.unit - self.present
        slope = np.broadcast_to(self.unit, matrix.shape).astype(complex)
        for through, (factor, rate) in zip(self.delayed, self.list_factors(roots), strict=True):
            with np.errstate(invalid="ignore"):
                matrix = matrix - factor[:, None, None] * through
                slope = slope - rate[:, None, None] * through
        return matrix, slope

    def list_factors(self, roots: Complex | complex) -> list[tuple[Complex, Complex]]:
        """Return what each term is multiplied by, and the derivative of that in lambda, of the shape of ``roots``.

        Where an exponential overflows they are not finite.
        """
        found = []
        orders = np.zeros(len(self.delays), dtype=np.intp) if self.orders is None else self.orders
        for tau, m in zip(self.delays.tolist(), orders.tolist(), strict=True):
            with np.errstate(over="ignore", invalid="ignore"):
                factor, rate = find_transfer_factor(self.method, roots * tau)
                rate = tau * rate
                if m:
                    factor, rate = roots**m * factor, m * roots ** (m - 1) * factor + roots**m * rate
            found.append((factor, rate))
        return found

    def find_bound(self) -> float:
        """Return a number that no root to the right of the imaginary axis exceeds in modulus, where |H| <= 1.

        It is the largest eigenvalue of |A_0| + sum_k |A_k|, from above by Collatz and Wielandt's quotients.
        """
        sizes = abs(self.present) + sum(abs(m) for m in self.delayed)
        vector = np.ones(self.n)
        bound = np.inf
        for _ in range(QUOTIENTS):
            image = sizes @ vector
            bound = min(bound, float(np.max(image / vector, initial=0.0)))
            vector = vector + image / max(bound, np.finfo(float).tiny)
            vector /= np.max(vector, initial=0.0)
        return bound

    def log_determinants(self, roots: Complex) -> Complex:
        """Return the logarithm of det Delta at several points (n_roots,), imaginary parts up to whole turns."""
        if not self.is_sparse:
            sign, logarithm = np.linalg.slogdet(self.at_many(roots)[0])
            return np.asarray(logarithm + 1j * np.angle(sign))
        return np.array([find_log_determinant(self.at(root)[0].astype(complex)) for root in roots.tolist()])

    def find_smallest(self, root: complex) -> tuple[float, Complex]:
        """Return the smallest singular value of Delta and its right vector (n,)."""
        matrix = self.at(root)[0]
        if not self.is_sparse:
            _, values, right = np.linalg.svd(matrix)
            return float(values[-1]), np.conj(right[-1])
        factors = scipy.sparse.linalg.splu(matrix.astype(complex).tocsc())
        vector = np.ones(self.n, dtype=complex) / np.sqrt(self.n)
        size = 1.0
        for _ in range(8):
            vector = factors.solve(factors.solve(vector, trans="H"))
            size = float(np.linalg.norm(vector))
            vector = vector / size
        return 1.0 / np.sqrt(size), vector

    def transpose(self) -> CharacteristicMatrix:
        """Return the matrix whose right vectors are this one's left ones."""
        return CharacteristicMatrix(
            self.present.T, tuple(m.T for m in self.delayed), self.delays, self.method, self.orders
        )
