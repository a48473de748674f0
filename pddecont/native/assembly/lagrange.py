"""Lagrange polynomials."""

from __future__ import annotations

from pddecont.native.arrays import Floats, entry

# A place nearer than this to a base point is that point: one over its distance overflows.
AT_POINT = 2.2250738585072014e-308


@entry
def evaluate_lagrange(sigma: Floats, n: int, base: Floats, barycentric: Floats, m: int, weights: Floats) -> None:
    """Write the values at each of ``n`` places of the polynomials of ``m`` base points, ``weights`` (n, m).

    By the second barycentric formula: Berrut, Trefethen, SIAM Review 46 (2004), eq. (4.2).
    """
    for i in range(n):
        hit = -1
        total = 0.0
        for k in range(m):
            gap = sigma[i] - base[k]
            if abs(gap) < AT_POINT:
                hit = k
                break
            term = barycentric[k] / gap
            weights[i * m + k] = term
            total += term
        for k in range(m):
            if hit >= 0:
                weights[i * m + k] = 1.0 if k == hit else 0.0
            else:
                weights[i * m + k] /= total
