"""The characteristic matrix of an equilibrium, whose singular values of lambda are its characteristic roots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.continuation import factor, find_log_determinant
from pddecont.delay import DelayMethod, find_transfer_factor
from pddecont.equilibrium.distributed import DistributedTerm
from pddecont.equilibrium.neutral import find_neutral_bound, find_neutral_radius
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Matrices of more rows are sparse.
DENSE = 120
# Entries of matrices that are made at a time.
ENTRIES = 1_000_000
# Rounds in which the bound of roots is made smaller.
QUOTIENTS = 30


@dataclass(frozen=True, eq=False)
class CharacteristicMatrix:
    """Delta(lambda) = lambda I - A_0 - sum_k A_k lambda^m_k H(lambda tau_k) - sum_q K_q(lambda).

    H is what the method does to exponentials, K_q what reads the past through integrals (``distributed``). ``present``
    A_0 has shape (n, n), ``delayed`` A_k that shape for each term, ``delays`` tau_k shape (n_terms,). ``orders`` m_k
    say how often a state is differentiated where it is read (None: never).
    Matrices are arrays, or sparse in CSC form. Reference: Hale, Verduyn Lunel, Introduction to Functional Differential
    Equations (1993), chapter 7.
    """

    present: Any
    delayed: tuple[Any, ...]
    delays: Array
    method: DelayMethod
    orders: NDArray[np.intp] | None = None
    distributed: tuple[DistributedTerm, ...] = ()

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

    @cached_property
    def read_orders(self) -> NDArray[np.intp]:
        """How often the state of each term is differentiated (n_terms,)."""
        return np.zeros(len(self.delays), dtype=np.intp) if self.orders is None else self.orders

    @cached_property
    def longest(self) -> float:
        """The longest lag at which the past is read."""
        return max(float(np.max(self.delays, initial=0.0)), *(term.longest for term in self.distributed), 0.0)

    @cached_property
    def _entries(self) -> tuple[Any, Array]:
        """A sparse matrix with an entry wherever one has any, and those of I, A_0 and each A_k in its place."""
        parts = [self.unit, self.present, *self.delayed]
        ones = [sp.csc_matrix((np.ones(m.nnz), m.indices, m.indptr), shape=m.shape) for m in map(sp.csc_matrix, parts)]
        pattern = sum(ones[1:], ones[0])
        pattern.sort_indices()
        return pattern, np.stack([_place(sp.csc_matrix(part), pattern) for part in parts])

    def at(self, root: complex) -> tuple[Any, Any]:
        """Return Delta and its derivative in lambda, shape (n, n) each."""
        factors = self.list_factors(root)
        if self.is_sparse:
            pattern, entries = self._entries
            weights = np.array([[root, -1.0, *(-f for f, _ in factors)], [1.0, 0.0, *(-rate for _, rate in factors)]])
            matrices = tuple(
                sp.csc_matrix((data, pattern.indices, pattern.indptr), shape=pattern.shape)
                for data in weights.astype(complex) @ entries
            )
            return self._subtract_distributed(matrices, root)
        matrix, slope = root * self.unit - self.present, self.unit.astype(complex)
        for through, (share, rate) in zip(self.delayed, factors, strict=True):
            matrix = matrix - complex(share) * through
            slope = slope - complex(rate) * through
        return self._subtract_distributed((matrix, slope), root) if self.distributed else (matrix, slope)

    def _subtract_distributed(self, matrices: tuple[Any, ...], root: complex) -> tuple[Any, ...]:
        """Return Delta and its derivative less what is read through integrals."""
        for term in self.distributed:
            parts = (
                sp.csc_matrix((v, (term.rows, term.columns)), shape=(self.n, self.n)) for v in term.transform(root)
            )
            matrices = tuple(
                whole - (part if self.is_sparse else part.toarray())
                for whole, part in zip(matrices, parts, strict=True)
            )
        return matrices

    def at_many(self, roots: Complex) -> tuple[Complex, Complex]:
        """Return the same at several points, shape (n_roots, n, n) each; of dense matrices."""
        matrix = roots[:, None, None] * self.unit - self.present
        slope = np.broadcast_to(self.unit, matrix.shape).astype(complex)
        for through, (share, rate) in zip(self.delayed, self.list_factors(roots), strict=True):
            with np.errstate(invalid="ignore"):
                matrix = matrix - share[:, None, None] * through
                slope = slope - rate[:, None, None] * through
        for term in self.distributed:
            for whole, part in zip((matrix, slope), term.transform(roots), strict=True):
                for entry, (row, column) in enumerate(zip(term.rows.tolist(), term.columns.tolist(), strict=True)):
                    whole[:, row, column] -= part[:, entry]
        return matrix, slope

    def list_factors(self, roots: Complex | complex) -> list[tuple[Complex, Complex]]:
        """Return what each term is multiplied by, and the derivative of that in lambda, of the shape of ``roots``.

        Where an exponential overflows they are not finite.
        """
        delays, orders = self.delays.tolist(), self.read_orders.tolist()
        if self.method.stages is not None or any(orders):
            return [find_share(self.method, roots, tau, m) for tau, m in zip(delays, orders, strict=True)]
        with np.errstate(over="ignore", invalid="ignore"):
            shares = np.exp(-np.multiply.outer(self.delays, roots))
            return [(share, -tau * share) for tau, share in zip(delays, shares, strict=True)]

    @cached_property
    def neutral_radius(self) -> float:
        """How strong the terms are through which rates of the past are read: below one, or the equation is none."""
        return find_neutral_radius(self._rates, self.delays[self.read_orders == 1].tolist())

    @cached_property
    def _rates(self) -> list[Any]:
        """The A_k through which rates are read."""
        return [m for m, order in zip(self.delayed, self.read_orders, strict=True) if order == 1]

    @cached_property
    def bound(self) -> float:
        """A number that no root to the right of the imaginary axis exceeds in modulus, where |H| <= 1.

        It is the largest eigenvalue of (I - sum |N_k|)^-1 (|A_0| + sum |A_k| + sum |K_q|), N_k those A_k through which
        rates are read, from above by Collatz and Wielandt's quotients. Where sum |N_k| has an eigenvalue of 1 or more
        it is another one, or infinite, as where higher derivatives are read: infinitely many such roots may be there.
        """
        orders = self.read_orders
        if np.any(orders > 1):
            return float("inf")
        values = [m for m, order in zip(self.delayed, orders, strict=True) if not order]
        sizes = sum((abs(m) for m in (*values, *self.list_sizes())), abs(self.present))
        rates = sum((abs(m) for m in self._rates), 0.0 * self.unit)
        if np.any(orders) and _find_largest(rates) >= 1.0:
            alike = len(set(self.delays[orders > 0].tolist())) == 1 and not self.is_sparse
            rates = sum(self._rates[1:], self._rates[0])
            return find_neutral_bound(rates, [self.present, *values], self.list_sizes()) if alike else float("inf")
        solve: Any = factor(self.unit - rates) if np.any(orders) else lambda v: v
        vector, bound = np.ones(self.n), np.inf
        for _ in range(QUOTIENTS):
            image = solve(sizes @ vector)
            bound = min(bound, float(np.max(image / vector, initial=0.0)))
            vector = vector + image / max(bound, np.finfo(float).tiny)
            vector /= np.max(vector, initial=0.0)
        return bound

    @cached_property
    def height(self) -> float:
        """A number that no root to the right of the imaginary axis exceeds in its imaginary part.

        It is the smaller one of the bound of the modulus and |A_0 - A_0^T|/2 + sum |A_k| in norms that are no less
        than spectral ones.
        """
        if np.any(self.read_orders > 0):
            return self.bound
        skew = 0.5 * find_norm(self.present - self.present.T)
        return min(self.bound, skew + self.reach)

    @cached_property
    def abscissa(self) -> float:
        """A number that no root exceeds in its real part where that is positive.

        It is the smaller one of the bound of the modulus and the largest eigenvalue of (A_0 + A_0^T)/2, by Gershgorin's
        discs, with sum |A_k|.
        """
        if np.any(self.read_orders > 0):
            return self.bound
        mean = 0.5 * (self.present + self.present.T)
        diagonal = mean.diagonal()
        rows = np.asarray(abs(mean).sum(axis=1)).ravel() - np.abs(diagonal)
        return max(0.0, min(self.bound, float(np.max(diagonal + rows)) + self.reach))

    @cached_property
    def reach(self) -> float:
        """The sum of the norms |A_k| and |K_q|, each no less than the spectral one."""
        return float(sum(np.sqrt(find_norm(m) * find_norm(m.T)) for m in (*self.delayed, *self.list_sizes())))

    def list_sizes(self) -> list[Any]:
        """Return matrices that the moduli of no K_q exceed to the right of the imaginary axis, shape (n, n) each."""
        found = []
        for term in self.distributed:
            sizes = sp.csc_matrix((term.sizes, (term.rows, term.columns)), shape=(self.n, self.n))
            found.append(sizes if self.is_sparse else sizes.toarray())
        return found

    def log_determinants(self, roots: Complex) -> Complex:
        """Return the logarithm of det Delta at several points (n_roots,), imaginary parts up to whole turns."""
        if not self.is_sparse:
            pieces = np.array_split(roots, 1 + len(roots) * self.n**2 // ENTRIES)
            found = [np.linalg.slogdet(self.at_many(piece)[0]) for piece in pieces]
            return np.concatenate([logarithm + 1j * np.angle(sign) for sign, logarithm in found])
        return np.array([find_log_determinant(self.at(root)[0].astype(complex)) for root in roots.tolist()])

    def find_null_vectors(self, roots: Complex) -> Complex:
        """Return the right vector of the smallest singular value of Delta at each of several points (n_roots, n)."""
        if self.is_sparse:
            vectors = [self.find_smallest(root)[1] for root in roots.tolist()]
            return np.array(vectors, dtype=complex).reshape(-1, self.n)
        return np.asarray(np.conj(np.linalg.svd(self.at_many(roots)[0])[2][:, -1]))

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
            self.present.T,
            tuple(m.T for m in self.delayed),
            self.delays,
            self.method,
            self.orders,
            tuple(term.transpose() for term in self.distributed),
        )


def find_share(method: DelayMethod, roots: Complex | complex, tau: float, order: int) -> tuple[Complex, Complex]:
    """Return lambda^order H(lambda tau) and its derivative in lambda, of the shape of ``roots``.

    Where an exponential overflows they are not finite.
    """
    share, rate = find_transfer_factor(method, roots * tau)
    with np.errstate(over="ignore", invalid="ignore"):
        rate = tau * rate
        if order:
            share, rate = roots**order * share, order * roots ** (order - 1) * share + roots**order * rate
    return share, rate


def find_norm(matrix: Any) -> float:
    """Return the largest sum of moduli in a row."""
    return float(np.max(np.asarray(abs(matrix).sum(axis=1))))


def _place(part: Any, pattern: Any) -> Array:
    """Return the entries of a sparse matrix in the places of a pattern that has them all (n_entries,)."""
    n = pattern.shape[0]
    columns = np.repeat(np.arange(n), np.diff(pattern.indptr))
    places = columns * n + pattern.indices
    part.sum_duplicates()
    own = np.repeat(np.arange(n), np.diff(part.indptr)) * n + part.indices
    values = np.zeros(len(places))
    values[np.searchsorted(places, own)] = part.data
    return values


def _find_largest(sizes: Any) -> float:
    """Return the largest eigenvalue of a matrix that is nowhere negative; of a large one what it cannot exceed."""
    return find_norm(sizes) if sp.issparse(sizes) else float(np.max(np.abs(np.linalg.eigvals(sizes))))
