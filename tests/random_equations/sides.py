"""Which side of each surface a motion is on, and along which it slides: flags of all signs, and Filippov's rule.

How fast a number changes along a field is its derivative by a complex step. Where both fields lead to a surface the
motion stays on it with the mean of the fields that keeps the number at zero.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import numpy as np

from tests.random_equations.laws import Law

STEP = 1e-30


class UnsureError(Exception):
    """The reference does not know how the motion goes on."""


@dataclass
class Sides:
    """A law whose first ``n`` values are the slopes of the states, with the flags of its signs.

    ``values`` are those that the law reads: states, t and delayed values. ``on`` are the labels along which the motion
    slides. ``grips`` holds static by kinetic friction by label, ``relays`` the labels with memory, ``fixed`` those
    whose numbers hold delayed values or time alone: along those nothing slides.
    """

    law: Law
    n: int
    grips: dict[str, float]
    relays: frozenset[str]
    fixed: frozenset[str]
    flags: dict[str, bool] = field(default_factory=dict)
    on: tuple[str, ...] = ()

    def evaluate(self, values):
        """Return the values of the law with the present flags."""
        self.law.flags = self.flags
        return self.law.evaluate(*values)

    def find_numbers(self, values):
        """Return the numbers whose signs the flags are, by label."""
        self.evaluate(values)
        return dict(self.law.numbers)

    def read_all(self, values):
        """Set the flags to the signs of their numbers; what one reads may depend on another."""
        for _ in range(8):
            now = {label: u > 0 for label, u in self.find_numbers(values).items()}
            if now == self.flags:
                return
            self.flags = now
        raise UnsureError("signs that depend on each other")

    def find_slopes(self, values):
        """Return the slopes of the states."""
        if not self.on:
            return np.array(self.evaluate(values)[: self.n], float)
        corners = self._find_corners(values, self.on)
        return self._mix(corners, self._find_weights(values, self.on, corners))

    def _find_corners(self, values, on):
        """Return the fields with each choice of flags on the surfaces ``on``."""
        fields, kept = {}, self.flags
        for chosen in product((False, True), repeat=len(on)):
            self.flags = kept | dict(zip(on, chosen, strict=True))
            fields[chosen] = np.array(self.evaluate(values)[: self.n], float)
        self.flags = kept
        return fields

    def _mix(self, corners, weights):
        """Return the mean of the corners' fields."""
        total = np.zeros(self.n)
        for chosen, f in corners.items():
            share = 1.0
            for up, h in zip(chosen, weights, strict=True):
                share *= h if up else 1.0 - h
            total = total + share * f
        return total

    def find_rate(self, label, values, f):
        """Return how fast a number changes along a field."""
        moved = [x + 1j * STEP * d for x, d in zip(values[: self.n], f, strict=True)]
        self.evaluate([*moved, values[self.n] + 1j * STEP, *values[self.n + 1 :]])
        u = self.law.numbers[label]
        return u.imag / STEP if isinstance(u, complex) else 0.0

    def _find_weights(self, values, on, corners, held=None):
        """Return the weights with which all numbers of ``on`` stay at zero; ``held`` has given ones."""
        held = held or {}
        free = [k for k, label in enumerate(on) if label not in held]
        weights = np.array([held.get(label, 0.5) for label in on])
        if not free:
            return weights

        def rates(h):
            f = self._mix(corners, h)
            return np.array([self.find_rate(on[k], values, f) for k in free])

        zero = weights.copy()
        zero[free] = 0.0
        base = rates(zero)
        matrix = np.empty((len(free), len(free)))
        for column, k in enumerate(free):
            one = zero.copy()
            one[k] = 1.0
            matrix[:, column] = rates(one) - base
        if abs(np.linalg.det(matrix)) < 1e-9:
            raise UnsureError("nothing decides how it slides")
        weights[free] = np.linalg.solve(matrix, -base)
        if np.max(np.abs(rates(weights))) > 1e-8 * (1.0 + np.max(np.abs(base))):
            raise UnsureError("laws that are multiplied")
        return weights

    def _find_bounds(self, label):
        grip = self.grips.get(label, 1.0)
        return (1.0 - grip) / 2.0, (1.0 + grip) / 2.0

    def find_end_rates(self, values, label):
        """Return the rates of a number at the lowest and the highest weight with which it can stay."""
        on = (*(o for o in self.on if o != label), label)
        corners = self._find_corners(values, on)
        result = []
        for bound in self._find_bounds(label):
            weights = self._find_weights(values, on, corners, {label: bound})
            result.append(self.find_rate(label, values, self._mix(corners, weights)))
        return result

    def decide(self, values, zero):
        """Choose the flags of the numbers that are zero, and along which of those the motion slides."""
        zero = sorted(zero)
        choices = [(False, True) if k in self.fixed or k in self.relays else (False, True, None) for k in zero]
        kept_flags, kept_on, found = self.flags, tuple(o for o in self.on if o not in zero), []
        for chosen in product(*choices):
            self.flags = kept_flags | {k: bool(c) for k, c in zip(zero, chosen, strict=True)}
            self.on = (*kept_on, *(k for k, c in zip(zero, chosen, strict=True) if c is None))
            if self._is_consistent(zero, chosen, values):
                found.append((self.flags, self.on))
        self.flags, self.on = kept_flags, kept_on
        if len(found) != 1:
            raise UnsureError(f"{len(found)} ways on from a surface")
        self.flags, self.on = found[0]

    def _is_consistent(self, zero, chosen, values):
        try:
            for label, c in zip(zero, chosen, strict=True):
                if label in self.fixed or label in self.relays:
                    continue
                corners = self._find_corners(values, self.on)
                if c is None:
                    lower, upper = self.find_end_rates(values, label)
                    if not (lower >= 0.0 >= upper and lower > upper):
                        return False
                    continue
                if label not in self.grips:
                    f = self._mix(corners, self._find_weights(values, self.on, corners))
                    rate = self.find_rate(label, values, f)
                else:
                    rate = self.find_end_rates(values, label)[1 if c else 0]
                if abs(rate) < 1e-7:
                    raise UnsureError("a field along its surface")
                if (rate > 0) != c:
                    return False
        except UnsureError as error:
            if "multiplied" in str(error) or "decides" in str(error):
                return False
            raise
        return True
