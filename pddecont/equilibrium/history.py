"""The past of a state as a linear system z' = F z + g q driven by the state q, whose outputs are its delayed values.

With it a linear delay equation becomes an ordinary one, whose eigenvalues lie next to characteristic roots: for the
delay itself the profile of the past on Chebyshev points, for a delay line exactly the states of the line.

Reference: Breda, Maset, Vermiglio, SIAM J. Sci. Comput. 27 (2005).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pddecont.collocation import make_basis
from pddecont.delay import LineStages
from pddecont.equilibrium.characteristic import CharacteristicMatrix

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HistorySystem:
    """z' = ``F`` z + ``g`` q; the value, or rate, that term k reads is ``C[k]`` z + ``d[k]`` q.

    Shapes: F (n_z, n_z), g (n_z,), C (n_terms, n_z), d (n_terms,). What entries of distributed terms read stands in
    ``integrals``, C (n_entries, n_z) and d (n_entries,) for each term.
    """

    F: Array
    g: Array
    C: Array
    d: Array
    integrals: tuple[tuple[Array, Array], ...] = ()


def make_history(matrix: CharacteristicMatrix, n_points: int) -> HistorySystem:
    """Return the history that a matrix reads; ``n_points`` + 1 Chebyshev points stand for the delay itself."""
    delays, method = matrix.delays, matrix.method
    moving = delays > 0.0
    if matrix.longest <= 0.0:
        return HistorySystem(np.zeros((0, 0)), np.zeros(0), np.zeros((len(delays), 0)), np.ones(len(delays)))
    if method.stages is None:
        return _make_profile(matrix, n_points)
    lines = [_join_stages(method.stages, tau) for tau in delays[moving].tolist()]
    sizes = np.cumsum([0, *(len(F) for F, _, _ in lines)])
    C, d = np.zeros((len(delays), sizes[-1])), np.where(moving, 0.0, 1.0)
    for line, k in enumerate(np.flatnonzero(moving).tolist()):
        C[k, sizes[line] : sizes[line + 1]] = lines[line][2]
    return HistorySystem(
        scipy.linalg.block_diag(*(F for F, _, _ in lines)), np.concatenate([g for _, g, _ in lines]), C, d
    )


def _make_profile(matrix: CharacteristicMatrix, n_points: int) -> HistorySystem:
    """Return the profile of the past on Chebyshev points from now to the longest lag."""
    basis, longest = make_basis(n_points), matrix.longest
    back = -basis.differentiate / longest
    reads = basis.lagrange(matrix.delays / longest)
    for m in range(1, int(np.max(matrix.read_orders, initial=0)) + 1):
        reads[matrix.read_orders >= m] = reads[matrix.read_orders >= m] @ back
    # The polynomials turn as fast as exponentials of so large an exponent.
    rate = 2.0 * n_points / longest
    integrals = [term.project(lambda s: basis.lagrange(s / longest).T, rate) for term in matrix.distributed]
    return HistorySystem(
        back[1:, 1:], back[1:, 0], reads[:, 1:], reads[:, 0], tuple((r[:, 1:], r[:, 0]) for r in integrals)
    )


def _join_stages(stages: LineStages, tau: float) -> tuple[Array, Array, Array]:
    """Return F, g and the output of delay lines one after another."""
    line, n, m = stages.line, stages.n, len(stages.line.mass)
    delta = tau / n
    own, drive = line.A / (line.mass[:, None] * delta), line.B / (line.mass * delta)
    F, g, out = np.zeros((n * m, n * m)), np.zeros(n * m), np.zeros(n * m)
    for k in range(n):
        F[k * m : (k + 1) * m, k * m : (k + 1) * m] = own
        if k:
            F[k * m : (k + 1) * m, (k - 1) * m + line.out] = drive
    g[:m] = drive
    out[(n - 1) * m + line.out] = 1.0
    return F, g, out
