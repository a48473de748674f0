"""Normal-form coefficients of folds and Hopf points of delay equations.

With Delta the characteristic matrix, B and C the second and third derivatives of the field as a functional of the past
(``expansion``) and phi = q e^(lambda t):

    fold    a  = p . B(phi, phi) / 2,                  Delta(0) q = 0,  p Delta(0) = 0,  p Delta'(0) q = 1,  |q| = 1
    Hopf    c1 = p . [C(phi, phi, conj phi) + 2 B(phi, h11) + B(conj phi, h20)] / 2,
            h11 = Delta(0)^-1 B(phi, conj phi),  h20 = Delta(2 i omega)^-1 B(phi, phi) e^(2 i omega t),
            l1 = Re c1 / omega,                        Delta(i omega) q = 0,  p Delta'(i omega) q = 1,  |q| = 1

On the centre manifold y' = a y^2 + ..., and z' = i omega z + c1 z |z|^2 + ... with x = x_0 + 2 Re(z q e^(i omega t)).
Orbits are born stable, beside a stable equilibrium, where l1 < 0. The size of a and l1 depends on |q| = 1, the sign of
a on that of q: its largest component is positive.

References: Kuznetsov, Elements of Applied Bifurcation Theory (2004), section 5.4; Janssens, On a normalization
technique for codimension two bifurcations of equilibria of delay differential equations (Utrecht, 2010); Bosschaert,
Janssens, Kuznetsov, SIAM J. Appl. Dyn. Syst. 19 (2020).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation import factor
from pddecont.equilibrium.equations import Equilibrium
from pddecont.equilibrium.expansion import Expansion, Exponential, Rest
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Components of a vector that differ by less than this part are as large as each other.
AS_LARGE = 1e-6


@dataclass(frozen=True, eq=False)
class CriticalRoot:
    """A root lambda of an equilibrium with its right and left vectors q and p (n_states,), |q| = 1, p Delta' q = 1."""

    root: complex
    right: Complex
    left: Complex


@dataclass(frozen=True, eq=False)
class Forms:
    """The multilinear forms of a field at an equilibrium."""

    at: Equilibrium

    @cached_property
    def matrix(self) -> Any:
        """The characteristic matrix."""
        return self.at.motion.linearise(self.at.states, self.at.parameters)

    @cached_property
    def rest(self) -> Rest:
        """What is read at the equilibrium."""
        return Rest(self.at)

    def second(self, u: Exponential, v: Exponential) -> Complex:
        """Return B(u, v) of two motions, shape (n_states,)."""
        return self._expand(u, v)

    def third(self, u: Exponential, v: Exponential, w: Exponential) -> Complex:
        """Return C(u, v, w)."""
        return self._expand(u, v, w)

    def solve(self, root: complex, right: Complex) -> Complex:
        """Return Delta(root)^-1 times a vector."""
        matrix = self.matrix.at(root)[0]
        solve: Any = factor(matrix.tocsc() if sp.issparse(matrix) else matrix)
        return np.asarray(solve(right.astype(complex)))

    def find_critical(self, root: complex) -> CriticalRoot:
        """Return a root of this equilibrium with its vectors."""
        _, q = self.matrix.find_smallest(root)
        _, p = self.matrix.transpose().find_smallest(root)
        if root.imag == 0.0:
            q, p = _make_real(q), _make_real(p)
        q = q / np.linalg.norm(q)
        p = p / (p @ (self.matrix.at(root)[1] @ q))
        return CriticalRoot(root, q, p)

    def _expand(self, *directions: Exponential) -> Complex:
        return np.asarray(Expansion(self.rest, directions).find_last(), dtype=complex)


def _make_real(vector: Complex) -> Complex:
    """Return a vector turned so that its largest component is positive; its imaginary part is rounding.

    Of several that are as large as each other it is the first.
    """
    sizes = np.abs(vector)
    largest = vector[int(np.argmax(sizes >= (1.0 - AS_LARGE) * np.max(sizes)))]
    return np.asarray((vector * np.conj(largest) / abs(largest)).real, dtype=complex)


def find_fold_coefficient(at: Equilibrium) -> float:
    """Return the coefficient a of a fold."""
    forms = Forms(at)
    critical = forms.find_critical(0.0 + 0.0j)
    phi = Exponential(critical.right, 0.0 + 0.0j)
    return float((critical.left @ forms.second(phi, phi)).real) / 2.0


def find_cubic_coefficient(forms: Forms, critical: CriticalRoot) -> complex:
    """Return the coefficient c1 of a Hopf point."""
    root = critical.root
    phi = Exponential(critical.right, root)
    bar = phi.conjugate()
    h11 = Exponential(forms.solve(0.0 + 0.0j, forms.second(phi, bar)), 0.0 + 0.0j)
    h20 = Exponential(forms.solve(2.0 * root, forms.second(phi, phi)), 2.0 * root)
    total = forms.third(phi, phi, bar) + 2.0 * forms.second(phi, h11) + forms.second(bar, h20)
    return complex(critical.left @ total) / 2.0


def find_root_speed(critical: CriticalRoot, before: Equilibrium, after: Equilibrium, between: float) -> complex:
    """Return d lambda / d s of a root along a branch, from equilibria ``between`` apart on both sides of it."""
    ends = [e.motion.linearise(e.states, e.parameters).at(critical.root)[0] for e in (before, after)]
    return complex(-critical.left @ ((ends[1] - ends[0]) @ critical.right)) / between
