"""Polynomials in a few small numbers e_1 .. e_k, each to the first order: e_j^2 = 0.

The coefficient of a product of some e_j is a multilinear form in what they multiply. A jet has shape (2^k, ...): where
the bits of the first index are those j. Composition with a function is the formula of Faa di Bruno: of f(y) the
coefficient of e_1 e_2 is

    f'' y_1 y_2 + f' y_12

and so on, one term for each way to part the e_j.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]


@cache
def list_partitions(mask: int) -> tuple[tuple[int, ...], ...]:
    """Return the ways to part a set of bits into parts that are not empty; of no bits there is one, into none."""
    if mask == 0:
        return ((),)
    first = mask & -mask
    rest, found = mask ^ first, []
    beside = rest
    while True:
        found += [(first | beside, *others) for others in list_partitions(rest ^ beside)]
        if beside == 0:
            return tuple(found)
        beside = (beside - 1) & rest


def multiply(a: Complex, b: Complex) -> Complex:
    """Return the product of jets."""
    result: Any = np.zeros(np.broadcast_shapes(a.shape, b.shape), dtype=complex)
    for one in range(len(a)):
        for other in range(len(b)):
            if not one & other:
                result[one | other] += a[one] * b[other]
    return np.asarray(result)


def make_decay(root: complex, delta: Complex) -> Complex:
    """Return exp(-root delta) of a jet without a constant term."""
    term = np.zeros_like(delta)
    term[0] = 1.0
    total = term.copy()
    for order in range(1, len(delta).bit_length()):
        term = multiply(term, -root / order * delta)
        total += term
    return total
