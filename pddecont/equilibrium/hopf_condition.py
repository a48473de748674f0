"""A pair of roots +-i omega along a curve, in unknowns that stay regular where omega is zero.

With the parts of Delta(lambda) = R(-lambda^2) + lambda S(-lambda^2), R and S real, and q = u + i omega w the equation
Delta(i omega) q = 0 is

    R(s) u - s S(s) w = 0,    R(s) w + S(s) u = 0,    c . u = 1,  c . w = d,        s = omega^2

where c and d are those that u and w of the point before have. At a Bogdanov-Takens point s = 0, u is the null vector
and w the generalised one; no fold but this one solves the equations. Beyond, where s < 0, the roots are +-sqrt(-s), and
no orbits are born.

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), section 10.2.2; Govaerts, Numerical Methods for
Bifurcations of Dynamical Equilibria (2000), section 4.3.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.characteristic import CharacteristicMatrix
from pddecont.equilibrium.critical import DIFFERENCE, Critical, make_dense
from pddecont.equilibrium.critical_roots import find_pair, leave_out
from pddecont.equilibrium.equations import EquilibriumEvaluation, EquilibriumProblem
from pddecont.equilibrium.roots import Roots

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Where a root turns or decays by less than this in the longest delay its odd part is an integral, not a quotient.
SLOW = 0.1
# Nodes and weights of the integral over -1 .. 1: an error of the order of SLOW^8 / 8!.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, eq=False)
class HopfCondition(Critical):
    """A pair of roots +-i omega; the unknowns are u, w and omega^2. ``pace`` is a frequency that is typical of it.

    ``normal`` c and ``offset`` d choose one of the vectors, which all are multiples of each other.
    """

    normal: Array
    pace: float
    offset: float = 0.0

    @property
    def label(self) -> str:
        """HB."""
        return "HB"

    def count_unknowns(self, problem: EquilibriumProblem) -> int:
        """Return the number of components of u and w and one."""
        return 2 * problem.motion.n_states + 1

    def find_scale(self, sizes: Array, own: Array) -> Array:
        """Return one for u, and powers of the typical frequency for the others."""
        n = len(own) // 2
        return np.concatenate([np.ones(n), np.full(n, 1.0 / self.pace), [self.pace**2]])

    def evaluate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return R u - s S w, R w + S u, c . u - 1 and c . w - d."""
        u, w, square = _split(own)
        even, odd = _split_parity(_linearise(inner), square)
        conditions = [self.normal @ u - 1.0, self.normal @ w - self.offset]
        return np.concatenate([even @ u - square * (odd @ w), even @ w + odd @ u, conditions])

    def differentiate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return the derivatives: in u and w exact, in s by central differences.

        The block pattern:

                 u    w    s
                 R   -s S  #
                 S    R    #
                 c
                      c
        """
        n, square = len(own) // 2, float(own[-1])
        even, odd = (make_dense(part) for part in _split_parity(_linearise(inner), square))
        result = np.zeros((2 * n + 2, 2 * n + 1))
        result[:n, :n], result[:n, n : 2 * n] = even, -square * odd
        result[n : 2 * n, :n], result[n : 2 * n, n : 2 * n] = odd, even
        result[2 * n, :n] = result[2 * n + 1, n : 2 * n] = self.normal
        step = np.append(np.zeros(2 * n), DIFFERENCE * self.pace**2)
        ends = [self.evaluate(inner, own + sign * step) for sign in (-1.0, 1.0)]
        result[:, -1] = (ends[1] - ends[0]) / (2.0 * step[-1])
        return result

    def update(self, own: Array) -> Critical:
        """Return the condition with the present vector as normal; it solves that one too."""
        u, w, _ = _split(own)
        return replace(self, normal=u / (u @ u), offset=float(u @ w / (u @ u)))

    def remove_own(self, roots: Roots, own: Array) -> Roots:
        """Return the roots without the pair."""
        return leave_out(roots, find_pair(roots, cmath.sqrt(-_split(own)[2])))


def find_frequency(own: Array) -> float:
    """Return the frequency omega from the unknowns of a Hopf point; zero where there is none."""
    return float(np.sqrt(max(_split(own)[2], 0.0)))


def start_at_pair(q: Complex, omega: float) -> tuple[HopfCondition, Array]:
    """Return the condition and the unknowns of a pair +-i ``omega`` with a vector q (n_states,).

    q is turned so that its real part is the longest, which its imaginary part is perpendicular to.
    """
    turned = q * cmath.exp(-0.5j * cmath.phase(complex(q @ q)))
    u, w = turned.real / np.linalg.norm(turned.real), turned.imag / (omega * np.linalg.norm(turned.real))
    return HopfCondition(u, omega), np.concatenate([u, w, [omega**2]])


def start_at_double_zero(inner: EquilibriumEvaluation) -> tuple[HopfCondition, Array]:
    """Return the condition and the unknowns where zero is a double root."""
    matrix = _linearise(inner)
    even, odd = (make_dense(part) for part in _split_parity(matrix, 0.0))
    u = np.linalg.svd(even)[2][-1]
    # R w = -S u with c . w = 0: solvable to the accuracy of the point.
    w = np.linalg.lstsq(np.vstack([even, u]), np.append(-odd @ u, 0.0), rcond=None)[0]
    pace = 1.0 / max(float(np.linalg.norm(w)), matrix.longest)
    return HopfCondition(u, pace), np.concatenate([u, w, [0.0]])


def _split(own: Array) -> tuple[Array, Array, float]:
    n = len(own) // 2
    return own[:n], own[n : 2 * n], float(own[-1])


def _linearise(inner: EquilibriumEvaluation) -> CharacteristicMatrix:
    at = inner.equilibrium
    return at.motion.linearise(at.states, at.parameters)


def _split_parity(matrix: CharacteristicMatrix, square: float) -> Sequence[Any]:
    """Return R and S where lambda^2 is minus ``square``, shape (n, n) each.

    S is half of the integral of Delta'(lambda t) over t from -1 to 1.
    """
    root = cmath.sqrt(-square)
    here = matrix.at(root)[0]
    there = here.conj() if square > 0.0 else matrix.at(-root)[0]
    even = (0.5 * (here + there)).real
    if abs(root) * matrix.longest >= SLOW:
        return even, ((here - there) / (2.0 * root)).real
    slopes = [0.5 * weight * matrix.at(root * node)[1] for node, weight in zip(NODES, WEIGHTS, strict=True)]
    return even, sum(slopes[1:], slopes[0]).real
