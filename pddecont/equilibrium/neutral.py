"""Rates of the past in a linear delay equation: x'(t) - sum_k N_k x'(t - tau_k) = ...

High up along the imaginary axis characteristic roots come near those of det(I - sum_k N_k exp(-lambda tau_k)). They
stay to its left for all delays near tau_k where the radius

    gamma = max over theta of rho(sum_k N_k exp(i theta_k))

is below one; from one on infinitely many may lie to its right, and next to one small changes put them there.

Reference: Hale, Verduyn Lunel, IMA J. Math. Control Inf. 19 (2002) 5-23, section 3.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.sparse as sp
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Phases that are tried of each delay but one, and delays of which all are; of more the radius is one from above.
PHASES, MOST_DELAYS = 24, 3
# Of larger matrices radii are bounds by their norms.
LARGE = 120


def find_neutral_radius(matrices: Sequence[Any], delays: Sequence[float]) -> float:
    """Return gamma of matrices N_k (n, n) of rates that are read ``delays`` ago; zero without any."""
    by_delay: dict[float, Any] = {}
    for matrix, tau in zip(matrices, delays, strict=True):
        by_delay[tau] = by_delay.get(tau, 0.0) + matrix
    parts = list(by_delay.values())
    if not parts:
        return 0.0
    n = parts[0].shape[0]
    if n > LARGE:
        return float(max(sp.csc_matrix(sum(abs(m) for m in parts)).sum(axis=1).max(), 0.0))
    if n == 1 or len(parts) > MOST_DELAYS:
        return _find_radius(sum(abs(m) for m in parts))
    if len(parts) == 1:
        return _find_radius(parts[0])

    def measure(theta: Array) -> float:
        turned = [m * np.exp(1j * angle) for m, angle in zip(parts[1:], theta, strict=True)]
        return -_find_radius(sum(turned, parts[0].astype(complex)))

    angles = 2.0 * np.pi / PHASES * np.arange(PHASES)
    start = min((np.array(t) for t in itertools.product(angles, repeat=len(parts) - 1)), key=measure)
    best = scipy.optimize.minimize(measure, start, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-14})
    return max(-float(best.fun), -measure(start))


def find_neutral_bound(rates: Array, matrices: Sequence[Array], sizes: Sequence[Array]) -> float:
    """Return what no root to the right of the imaginary axis exceeds in modulus, with one N of a radius below one.

    In the norm |x|^2 = x . P x with P = sum_j (N^T)^j N^j, in which N is less than one, it is sum |A| / (1 - |N|) over
    the ``matrices`` A and those whose entries have moduli up to ``sizes``. Infinite where the radius is one or more.
    """
    if _find_radius(rates) >= 1.0:
        return float("inf")
    try:
        upper = scipy.linalg.cholesky(scipy.linalg.solve_discrete_lyapunov(rates.T, np.eye(len(rates))))
    except np.linalg.LinAlgError:
        return float("inf")
    inverse = scipy.linalg.inv(upper)
    own = float(np.linalg.norm(upper @ rates @ inverse, 2))
    products = [upper @ a @ inverse for a in matrices] + [np.abs(upper) @ a @ np.abs(inverse) for a in sizes]
    others = sum(float(np.linalg.norm(product, 2)) for product in products)
    return others / (1.0 - own) if own < 1.0 else float("inf")


def _find_radius(matrix: Any) -> float:
    return float(np.max(np.abs(np.linalg.eigvals(matrix))))
