"""The vector field along a rest with small exponential motions beside it, to the first order in each.

Along x + sum_j e_j q_j exp(lambda_j t) the coefficient of e_1 e_2 is the second derivative B(u_1, u_2) of the field as
a functional of the past, that of e_1 e_2 e_3 the third one, u_j the j-th motion. A value read by a delay that varies is

    x(t - tau) = x + sum_j e_j q_j exp(lambda_j (t - tau_0)) exp(-lambda_j (tau - tau_0))

with the delay's own expansion tau - tau_0, and an integral is that over fixed lags with what its limits move over.

Reference: Sieber, Discrete Contin. Dyn. Syst. 32 (2012) 2607-2651, sections 3 and 4 (derivatives along smooth motions).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.equilibrium.characteristic import find_share
from pddecont.equilibrium.equations import Equilibrium
from pddecont.equilibrium.jets import list_partitions, make_decay, multiply
from pddecont.equilibrium.partials import ExpressionPartials
from pddecont.equilibrium.quadrature import find_panels, make_points
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Over what a limit moves the integrand is a polynomial of second degree at most.
STRIP_POINTS, STRIP_WEIGHTS = 0.5 + 0.5 * np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0]), np.array([5.0, 8.0, 5.0]) / 18.0


@dataclass(frozen=True, eq=False)
class Exponential:
    """The motion ``vector`` exp(``root`` t), a vector (n_states,)."""

    vector: Complex
    root: complex

    def conjugate(self) -> Exponential:
        """Return the conjugate motion."""
        return Exponential(np.conj(self.vector), complex(self.root).conjugate())


@dataclass(frozen=True, eq=False)
class Place:
    """Where expressions are taken: time or lag t (n_points,), states (n_states, n_points), what is read there."""

    t: Array
    x: Array
    reads: Array


@dataclass(frozen=True, eq=False)
class Rest:
    """What a model reads at an equilibrium, and of exponential motions there: the same for all expansions."""

    at: Equilibrium
    _shares: dict[complex, Complex] = field(default_factory=dict, repr=False)

    @cached_property
    def place(self) -> Place:
        """The equilibrium as one point."""
        at = self.at
        return Place(np.zeros(1), at.states[:, None], at.motion.read(at.states, at.parameters)[:, None])

    @cached_property
    def lags(self) -> Array:
        """How long ago values are read (n_delays,)."""
        at = self.at
        return at.motion.reads.find_lags(at.states, self.place.reads[:, 0], at.parameters)

    def find_shares(self, root: complex) -> Complex:
        """Return what delayed values are of the present one of a motion exp(root t), by these lags (n_delayed,)."""
        if root not in self._shares:
            model, method = self.at.motion.numeric.model, self.at.motion.method
            groups = dict.fromkeys((v.delay, v.derivative) for v in model.delayed)
            share = {g: complex(find_share(method, root, float(self.lags[g[0]]), g[1])[0]) for g in groups}
            self._shares[root] = np.array([share[v.delay, v.derivative] for v in model.delayed], dtype=complex)
        return self._shares[root]


@dataclass(frozen=True, eq=False)
class Expansion:
    """The expansion of what a model reads at an equilibrium along ``directions``, at most three; see ``jets``."""

    rest: Rest
    directions: tuple[Exponential, ...]
    _known: dict[int, Complex] = field(default_factory=dict, repr=False)

    @property
    def at(self) -> Equilibrium:
        """The equilibrium."""
        return self.rest.at

    @property
    def n_terms(self) -> int:
        """Number of coefficients of a jet."""
        return 1 << len(self.directions)

    def find_last(self) -> Complex:
        """Return the coefficient of the product of all e_j of the vector field, shape (n_states,)."""
        partials = self.at.motion.partials
        return self._compose(partials, self._list_arguments(partials), self.rest.place, self.n_terms - 1)[:, 0]

    def _compose(
        self, partials: ExpressionPartials, arguments: Sequence[Complex], place: Place, mask: int
    ) -> NDArray[Any]:
        """Return a coefficient of expressions (n_exprs, n_points), the one of the bits ``mask``.

        ``arguments`` (n_arguments, n_points) are those of their arguments for each set of bits.
        """
        n, p = len(partials.exprs), self.at.parameters
        total: Any = np.zeros((n, len(place.t)))
        for parts in list_partitions(mask):
            if all(np.any(arguments[part]) for part in parts):
                of_order = partials.of_order(len(parts))
                values = of_order.function.value(place.t, place.x, place.reads, p)
                total = total + of_order.apply(values, [arguments[part] for part in parts], n)
        return np.asarray(total)

    def _expand(self, expr: sympy.Expr) -> Complex:
        """Return the jet of a delay or limit less its value at rest (n_terms,)."""
        partials = self.at.motion.find_partials((expr,))
        arguments, jet = self._list_arguments(partials), np.zeros(self.n_terms, dtype=complex)
        for mask in range(1, self.n_terms):
            jet[mask] = self._compose(partials, arguments, self.rest.place, mask)[0, 0]
        return jet

    def _list_arguments(self, partials: ExpressionPartials) -> list[Complex]:
        """Return the coefficients of the arguments of expressions at rest, (n_arguments, 1) for each set of bits."""
        model, n = self.at.motion.numeric.model, len(self.at.states)
        found = [np.zeros((len(partials.symbols), 1), dtype=complex) for _ in range(self.n_terms)]
        n_delayed = len(model.delayed)
        for j, u in enumerate(self.directions):
            found[1 << j][:n, 0] = u.vector
            found[1 << j][n : n + n_delayed, 0] = u.vector[self.at.motion.reads.states] * self.rest.find_shares(u.root)
        for number in (partials.used - n).tolist():
            if 0 <= number < len(model.read_symbols) and self._moves(number):
                jet = self._find_read(number)
                for mask in range(1, self.n_terms):
                    found[mask][n + number, 0] = jet[mask]
        return found

    def _moves(self, number: int) -> bool:
        """Return whether something read is an integral, or has a delay that varies."""
        model = self.at.motion.numeric.model
        return number >= len(model.delayed) or model.delayed[number].delay >= len(model.delays)

    def _find_read(self, number: int) -> Complex:
        """Return the jet of something read less its value at rest (n_terms,)."""
        if number not in self._known:
            n_delayed = len(self.at.motion.numeric.model.delayed)
            delayed = number < n_delayed
            self._known[number] = self._read_delayed(number) if delayed else self._read_integral(number - n_delayed)
        return self._known[number]

    def _read_delayed(self, number: int) -> Complex:
        model = self.at.motion.numeric.model
        read = model.delayed[number]
        lag, order = float(self.rest.lags[read.delay]), read.derivative
        delta, jet = self._expand(model.find_delay(read)), np.zeros(self.n_terms, dtype=complex)
        for j, u in enumerate(self.directions):
            start = np.zeros(self.n_terms, dtype=complex)
            start[1 << j] = u.vector[read.state] * u.root**order * np.exp(-u.root * lag)
            jet += multiply(start, make_decay(u.root, delta))
        return jet

    def _read_integral(self, number: int) -> Complex:
        """Return an integral over the lags at rest, and over the strips by which its limits move."""
        motion, at = self.at.motion, self.at
        integral = motion.numeric.model.integrals[number]
        low, high = motion.reads.find_limits(number, at.states, self.rest.place.reads[:, 0], at.parameters)
        partials = motion.find_partials((integral.integrand,))
        jet = np.zeros(self.n_terms, dtype=complex)
        if low != high:
            panels = find_panels(lambda s: self._list_slopes(partials, s), low, high)
            points, weights = make_points(panels, sum(abs(u.root) for u in self.directions))
            fixed = self._follow(partials, points, np.zeros((self.n_terms, 1), dtype=complex))
            jet += fixed @ weights
        for sign, at_rest, limit in ((1.0, high, integral.high), (-1.0, low, integral.low)):
            delta = self._expand(limit)
            if np.any(delta):
                strip = self._follow(partials, np.full(len(STRIP_POINTS), at_rest), delta[:, None] * STRIP_POINTS)
                jet += sign * multiply(delta, strip @ STRIP_WEIGHTS)
        jet[0] = 0.0
        return jet

    def _list_slopes(self, partials: ExpressionPartials, s: Array) -> Array:
        """Return all that an integrand's expansion over fixed lags is made of (n_functions, n_points)."""
        place = self._place(s)
        orders = (partials.of_order(order + 1) for order in range(len(self.directions)))
        return np.concatenate([o.function.value(place.t, place.x, place.reads, self.at.parameters) for o in orders])

    def _place(self, s: Array) -> Place:
        return Place(s, np.repeat(self.at.states[:, None], len(s), axis=1), np.zeros((0, len(s))))

    def _follow(self, partials: ExpressionPartials, s: Array, delta: Complex) -> Complex:
        """Return the jets of an integrand at lags ``s`` (n_points,), with constant terms, shape (n_terms, n_points).

        The lags move by the jets ``delta`` of the same shape.
        """
        n = len(self.at.states)
        arguments = np.zeros((self.n_terms, len(partials.symbols), len(s)), dtype=complex)
        arguments[:, -1] = delta
        for j, u in enumerate(self.directions):
            start = np.zeros((self.n_terms, len(s)), dtype=complex)
            start[1 << j] = np.exp(-u.root * s)
            along = multiply(start, make_decay(u.root, np.broadcast_to(delta, start.shape)))
            arguments[:, :n] += u.vector[None, :, None] * along[:, None]
        place, parts = self._place(s), list(arguments)
        return np.stack([self._compose(partials, parts, place, mask)[0] for mask in range(self.n_terms)]).astype(
            complex
        )
