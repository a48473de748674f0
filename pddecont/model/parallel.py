"""Switches whose functions differ by a number and a factor: surfaces are parallel, and some digits exclude others.

Of x - 1 > 0 and x < 0 no motion knows both. Where the difference depends on parameters its sign may change, and where
delayed values jump two surfaces are passed one after the other at one moment: there all digits may be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TypeAlias

import sympy

from pddecont.model.switches import ABOVE, BELOW, ON, Switch

# The digits of two switches, by their numbers, that motions may have at once.
Compatible: TypeAlias = Mapping[tuple[int, int], frozenset[tuple[int, int]]]


def find_compatible(switches: Sequence[Switch]) -> Compatible:
    """Return for each two switches with parallel surfaces which of their digits go together."""
    plain = [k for k, s in enumerate(switches) if s.drift is not None and s.drift.is_zero and not s.remembers]
    found = {}
    for i, j in combinations(plain, 2):
        related = _relate(switches[i].argument, switches[j].argument)
        if related is not None:
            found[i, j] = _list_pairs(*related)
    return found


def _relate(u: sympy.Expr, v: sympy.Expr) -> tuple[float, float] | None:
    """Return a and c with v = a u + c, c not zero; None if there are no such numbers."""
    own, other = (sympy.expand(e).as_coefficients_dict() for e in (u, v))
    term = next((t for t in own if t != 1), None)
    if term is None or term not in other:
        return None
    factor = other[term] / own[term]
    rest = sympy.expand(v - factor * u)
    return (float(factor), float(rest)) if rest.is_number and not rest.is_zero else None


def _list_pairs(factor: float, rest: float) -> frozenset[tuple[int, int]]:
    """Return the digits that u and factor u + rest have at once: on the surfaces, between them, and beyond."""
    root = -rest / factor
    places = (0.0, root, 0.5 * root, 2.0 * root, -root)
    values = ((u, 0.0 if u == root else factor * u + rest) for u in places)
    return frozenset((_find_digit(u), _find_digit(v)) for u, v in values)


def _find_digit(value: float) -> int:
    return ON if value == 0.0 else ABOVE if value > 0.0 else BELOW
