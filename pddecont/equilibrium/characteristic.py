"""The characteristic matrix of an equilibrium, whose singular values of lambda are its characteristic roots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.delay import DelayMethod, find_transfer_factor

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class CharacteristicMatrix:
    """Delta(lambda) = lambda I - A_0 - sum_k A_k H(lambda tau_k), H what the delay method does to exponentials.

    ``present`` A_0 has shape (n, n), ``delayed`` A_k shape (n_delays, n, n), ``delays`` tau_k shape (n_delays,).
    Reference: Hale, Verduyn Lunel, Introduction to Functional Differential Equations (1993), chapter 7.
    """

    present: Array
    delayed: Array
    delays: Array
    method: DelayMethod

    def at(self, root: complex) -> tuple[Complex, Complex]:
        """Return Delta and its derivative in lambda, shape (n, n) each."""
        unit: Complex = np.eye(len(self.present), dtype=complex)
        matrix, slope = root * unit - self.present, unit
        for through, tau in zip(self.delayed, self.delays, strict=True):
            factor, rate = find_transfer_factor(self.method, root * tau)
            matrix = matrix - factor * through
            slope = slope - tau * rate * through
        return matrix, slope

    def find_smallest(self, root: complex) -> tuple[float, Complex]:
        """Return the smallest singular value of Delta and its right vector (n,)."""
        _, values, right = np.linalg.svd(self.at(root)[0])
        return float(values[-1]), np.conj(right[-1])
