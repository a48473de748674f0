"""Laws with nonsmooth functions as plain Python, each function choosing its branch by a flag that is given.

A law is text that Python itself evaluates. Each nonsmooth function has a label for the sign it reads; what stands under
that label says which branch to take, and the number whose sign it is is noted. With the flags of a point's own signs
this is the function as anyone would write it; with the flags held it is smooth, also in complex numbers.
"""

from __future__ import annotations

import cmath
import math


def _both(real, cplx):
    return lambda a: cplx(a) if isinstance(a, complex) else real(a)


SMOOTH = {
    "cos": _both(math.cos, cmath.cos),
    "sin": _both(math.sin, cmath.sin),
    "tanh": _both(math.tanh, cmath.tanh),
    "pi": math.pi,
}


def _real(a):
    return a.real if isinstance(a, complex) else a


class Law:
    """Expressions of one law at given flags.

    ``names`` are the variables in the order in which values are given. ``flags`` says of each label whether its number
    counts as positive; ``numbers`` holds those numbers after an evaluation, thresholds of relays taken off.
    """

    def __init__(self, texts, names):
        self.flags, self.numbers = {}, {}
        known = {
            **SMOOTH,
            **{
                name: getattr(self, f"_{name}")
                for name in (
                    *("up", "sign", "heaviside", "absolute", "ramp", "larger", "smaller", "clip", "deadzone"),
                    *("relay", "mod", "square"),
                )
            },
        }
        self.evaluate = eval(f"lambda {', '.join(names)}: [{', '.join(texts)}]", known)

    def _up(self, label, u):
        self.numbers[label] = u
        return self.flags.get(label, False)

    def _sign(self, label, u):
        return 1.0 if self._up(label, u) else -1.0

    def _heaviside(self, label, u):
        return 1.0 if self._up(label, u) else 0.0

    def _absolute(self, label, u):
        return u if self._up(label, u) else -u

    def _ramp(self, label, u):
        return u if self._up(label, u) else 0.0 * u

    def _larger(self, label, a, b):
        return a if self._up(label, a - b) else b

    def _smaller(self, label, a, b):
        return b if self._up(label, a - b) else a

    def _clip(self, low_label, high_label, x, low, high):
        above_low, above_high = self._up(low_label, x - low), self._up(high_label, x - high)
        return high if above_high else x if above_low else low

    def _deadzone(self, low_label, high_label, x, low, high):
        above_low, above_high = self._up(low_label, x - low), self._up(high_label, x - high)
        return x - high if above_high else 0.0 * x if above_low else x - low

    def _relay(self, label, u, low, high):
        up = self.flags.get(label, False)
        self.numbers[label] = u - (low if up else high)
        return 1.0 if up else -1.0

    def _mod(self, label, t, period):
        turns = t / period
        first = self._up(label, self._angle(turns))
        moved = turns + 0.25 if first else turns - 0.25
        left = moved - math.floor(_real(moved))
        return period * (left - 0.25 if first else left + 0.25)

    def _square(self, label, t, period):
        return 1.0 if self._up(label, self._angle(t / period)) else -1.0

    @staticmethod
    def _angle(turns):
        return SMOOTH["sin"](2.0 * math.pi * turns)
