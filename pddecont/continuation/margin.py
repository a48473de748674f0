"""Margins: quantities such as delays that cannot become negative along a branch, which ends where one is used up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import bordered
from pddecont.continuation.locate import Located
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.settling import settled
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
# A margin that is smaller than this, for lengths of one along the branch, is none.
NONE_LEFT = 1e-12
MAX_TRIES = 6


def _no_margins(problem: Any, x: Array) -> tuple[Array, Array]:
    return np.zeros(0), np.zeros((0, len(x)))


@dataclass(frozen=True)
class Margins:
    """What cannot become negative along a branch.

    ``value(problem, x)`` returns the margins (n_margins,) and their slopes (n_margins, n_unknowns); ``words(problem, x, k)`` what
    margin ``k`` is, which is used up at ``x``.
    """

    value: Callable[[Any, Array], tuple[Array, Array]] = _no_margins
    words: Callable[[Any, Array, int], str] = lambda _problem, _x, k: f"margin {k}"

    def _with_nothing(self, problem: Any, x: Array) -> tuple[Array, Array, Array]:
        """Return the margins, their slopes, and how little counts as nothing of each."""
        values, slopes = self.value(problem, x)
        return values, slopes, NONE_LEFT * np.linalg.norm(slopes * problem.metric().size, axis=1)

    def used_up(self, problem: Any, x: Array, direction: Array) -> str:
        """Return which margin is used up at ``x`` and negative beyond, in words; empty if none is."""
        values, slopes, nothing = self._with_nothing(problem, x)
        ending = np.flatnonzero((values <= nothing) & (slopes @ direction < 0.0))
        return self.words(problem, x, int(ending[0])) if len(ending) else ""

    def overdrawn(self, problem: Any, x: Array) -> bool:
        """Whether a margin is negative at ``x``."""
        values, _, nothing = self._with_nothing(problem, x)
        return bool(np.any(values < -nothing))

    def end(self, problem: Any, base: Array, beyond: Array, settings: NewtonSettings) -> Located:
        """Return the branch's point at which the first margin is used up on the way from ``base`` to ``beyond``, where one is negative.

        Raises
        ------
        ConvergenceError
            If there is none to be found near that way.
        """
        before, after = np.maximum(self.value(problem, base)[0], 0.0), self.value(problem, beyond)[0]
        fractions = np.full(len(before), np.inf)
        np.divide(before, before - after, out=fractions, where=after < 0.0)
        first = int(np.argmin(fractions))
        guess = base + fractions[first] * (beyond - base)

        def solve(on_mesh: Any, from_: Array) -> Solution:
            values, slopes = self.value(on_mesh, from_)
            row = slopes[first]
            return bordered(on_mesh, row, float(row @ from_ - values[first]), from_, on_mesh.metric(), settings)

        for _ in range(MAX_TRIES):
            problem, solution = settled(problem, guess, solve)
            guess = solution.x
            values, _, nothing = self._with_nothing(problem, guess)
            if np.abs(values[first]) <= nothing[first]:
                return Located(problem, guess, solution)
        raise ConvergenceError("the end of the branch is not found")
