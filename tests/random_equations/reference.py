"""Motions of laws with nonsmooth functions, independent of the package: flags, Filippov's rule, scipy's DOP853.

Between events the flags of all signs are held, so that the law is smooth; the numbers whose signs they are end the
arc where they pass zero. How fast such a number changes along a field is its derivative by a complex step. Where both
fields lead to a surface the motion stays on it with the mean of the fields that keeps the number at zero. Delayed
values are read from the dense output of steps that end at breaking points.

Where the rules do not decide, or where a number only just reaches zero, nothing is said: :class:`UnsureError`.
"""

from __future__ import annotations

import bisect
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

from tests.random_equations.laws import Law

RTOL, ATOL = 1e-11, 1e-13
# A number this near to zero at an event is zero; one that comes this near without passing it grazes.
ON_SURFACE, GRAZING = 1e-9, 1e-6
# Times closer than this are one; what was zero at an event is looked at so much later.
SAME_TIME, LATER = 1e-10, 1e-5
STEP, ECHOES, LARGE = 1e-30, 3, 1e3
SAMPLES = np.linspace(0.0, 1.0, 13)


class UnsureError(Exception):
    """The reference does not know how the motion goes on."""


@dataclass(frozen=True)
class Impact:
    """A jump: at the zero of ``text`` in a direction, or ``delay`` after the jump ``after``.

    ``reset`` are the texts of all states after it; ``only`` the flags that it asks for.
    """

    name: str
    text: str | None
    direction: int
    reset: tuple[str, ...]
    after: str = ""
    delay: float = 0.0
    only: tuple[tuple[str, bool], ...] = ()


@dataclass
class Reference:
    """A motion of ``texts`` (one a state) from ``start``, which is its history too.

    ``grips`` holds static by kinetic friction by label, ``relays`` the labels with memory, ``fixed`` those whose
    numbers hold delayed values or time alone: along those nothing slides.
    """

    states: tuple[str, ...]
    texts: tuple[str, ...]
    start: np.ndarray
    tau: float | None = None
    impacts: tuple[Impact, ...] = ()
    grips: dict[str, float] = field(default_factory=dict)
    relays: frozenset[str] = frozenset()
    fixed: frozenset[str] = frozenset()
    accuracy: float = 1.0

    def __post_init__(self):
        past = [f"{s}_tau" for s in self.states] if self.tau else []
        self.names = [*self.states, "t", *past]
        n = len(self.states)
        self.law = Law([*self.texts, *(i.text or "0.0" for i in self.impacts)], self.names)
        self.resets = {i.name: Law(i.reset, self.names) for i in self.impacts}
        self.n, self.t, self.z = n, 0.0, np.array(self.start, float)
        self.edges, self.pieces, self.events, self.pending = [], [], [], []
        self.breaks = [k * self.tau for k in range(1, ECHOES + 1)] if self.tau else []
        self.on, self.flags, self.slid, self.grazed = (), {}, 0.0, np.inf
        self._find_labels()
        zero = {label for label, u in self._numbers(self.z, self.t).items() if abs(u) < ON_SURFACE}
        values = self._values(self.z.tolist(), 0.0)
        for label in zero & self.fixed:
            self.flags[label] = self._rate(label, values, np.zeros(n)) > 0
        self._decide(zero - self.fixed - self.relays)

    # What the law says.

    def read(self, t):
        """Return the states at a time that is over."""
        if t <= 0.0 or not self.pieces:
            return np.asarray(self.start, float)
        return self.pieces[max(bisect.bisect_right(self.edges, t + SAME_TIME) - 1, 0)](t)

    def _values(self, z, t, side=1.0):
        past = self.read(t - self.tau + side * 0.0) if self.tau else ()
        return [*z, t, *past]

    def _evaluate(self, values):
        self.law.flags = self.flags
        return self.law.evaluate(*values)

    def _numbers(self, z, t):
        self._evaluate(self._values(np.asarray(z).tolist(), float(t)))
        return dict(self.law.numbers)

    def _find_labels(self):
        """Set the flags to the signs at the start; what one reads may depend on another."""
        values = self._values(self.z.tolist(), 0.0)
        for _ in range(8):
            self._evaluate(values)
            now = {label: u > 0 for label, u in self.law.numbers.items()}
            if now == self.flags:
                return
            self.flags = now
        raise UnsureError("signs that depend on each other")

    def _corners(self, values, on):
        """Return the fields with each choice of flags on the surfaces ``on``."""
        fields, kept = {}, self.flags
        for chosen in product((False, True), repeat=len(on)):
            self.flags = kept | dict(zip(on, chosen, strict=True))
            fields[chosen] = np.array(self._evaluate(values)[: self.n], float)
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

    def _rate(self, label, values, f):
        """Return how fast a number changes along a field."""
        moved = [x + 1j * STEP * d for x, d in zip(values[: self.n], f, strict=True)]
        self._evaluate([*moved, values[self.n] + 1j * STEP, *values[self.n + 1 :]])
        u = self.law.numbers[label]
        return u.imag / STEP if isinstance(u, complex) else 0.0

    def _weights(self, values, on, corners, held=None):
        """Return the weights with which all numbers of ``on`` stay at zero; ``held`` has given ones."""
        held = held or {}
        free = [k for k, label in enumerate(on) if label not in held]
        weights = np.array([held.get(label, 0.5) for label in on])
        if not free:
            return weights

        def rates(h):
            f = self._mix(corners, h)
            return np.array([self._rate(on[k], values, f) for k in free])

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

    def _field(self, t, z):
        values = self._values(z.tolist(), float(t))
        if not self.on:
            return np.array(self._evaluate(values)[: self.n], float)
        corners = self._corners(values, self.on)
        return self._mix(corners, self._weights(values, self.on, corners))

    def _bounds(self, label):
        grip = self.grips.get(label, 1.0)
        return (1.0 - grip) / 2.0, (1.0 + grip) / 2.0

    def _end_rates(self, z, t, label):
        """Return the rates of a number at the lowest and the highest weight with which it can stay."""
        values = self._values(np.asarray(z).tolist(), float(t))
        on = (*(o for o in self.on if o != label), label)
        corners = self._corners(values, on)
        result = []
        for bound in self._bounds(label):
            weights = self._weights(values, on, corners, {label: bound})
            result.append(self._rate(label, values, self._mix(corners, weights)))
        return result

    # What happens at an event.

    def _decide(self, zero):
        """Choose the flags of the numbers that are zero, and along which of those the motion slides."""
        zero = sorted(zero)
        values = self._values(self.z.tolist(), self.t)
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
                corners = self._corners(values, self.on)
                if c is None:
                    lower, upper = self._end_rates(self.z, self.t, label)
                    if not (lower >= 0.0 >= upper and lower > upper):
                        return False
                    continue
                if label not in self.grips:
                    f = self._mix(corners, self._weights(values, self.on, corners))
                    rate = self._rate(label, values, f)
                else:
                    rate = self._end_rates(self.z, self.t, label)[1 if c else 0]
                if abs(rate) < 1e-7:
                    raise UnsureError("a field along its surface")
                if (rate > 0) != c:
                    return False
        except UnsureError as error:
            if "multiplied" in str(error) or "decides" in str(error):
                return False
            raise
        return True

    def _read_late(self):
        """Read the signs of delayed values where those may have jumped."""
        numbers = self._numbers(self.z, self.t)
        now = {k: numbers[k] > 0 for k in self.fixed if abs(numbers.get(k, 0.0)) > GRAZING}
        if any(self.flags[k] != up for k, up in now.items()):
            self.flags = self.flags | now
            self._note("late")
            self._decide(set(self.on))

    def _reread(self):
        """Read the flags after the states have jumped."""
        on = set()
        for _ in range(8):
            numbers, now = self._numbers(self.z, self.t), {}
            for label, u in numbers.items():
                now[label] = u >= 0 if label in self.relays and self.flags[label] else u > 0
                if label not in self.relays and label not in self.fixed and abs(u) < ON_SURFACE:
                    on.add(label)
                    now[label] = self.flags[label]
                elif abs(u) < GRAZING and label not in self.fixed:
                    raise UnsureError("a jump almost onto a surface")
            if now == self.flags:
                break
            self.flags = now
        else:
            raise UnsureError("signs that depend on each other")
        self.on = tuple(o for o in self.on if o in on)
        if on:
            self._decide(on)

    def _jump(self, impact):
        law = self.resets[impact.name]
        law.flags = self.flags
        for label, wanted in impact.only:
            if label in self.on or self.flags[label] != wanted:
                return
        values = self._values(self.z.tolist(), self.t)
        self.z = np.array(law.evaluate(*values), float)
        self._note(impact.name)
        for other in self.impacts:
            if other.after == impact.name:
                bisect.insort(self.pending, (self.t + other.delay, other.name))
        self._reread()

    def _note(self, what):
        self.events.append((self.t, what))
        if self.tau:
            for k in range(1, ECHOES + 1):
                bisect.insort(self.breaks, self.t + k * self.tau)

    # Integration.

    def run(self, t_end):
        """Integrate to a time; return this motion."""
        while self.t < t_end - SAME_TIME:
            while self.breaks and self.breaks[0] <= self.t + SAME_TIME:
                self.breaks.pop(0)
            stop = min([t_end, *self.breaks[:1], *(time for time, _ in self.pending[:1])])
            self._arc(stop)
            while self.pending and self.pending[0][0] <= self.t + SAME_TIME:
                _, name = self.pending.pop(0)
                self._jump(next(i for i in self.impacts if i.name == name))
            if self.tau and self.breaks and abs(self.breaks[0] - self.t) < SAME_TIME:
                self._read_late()
            if len(self.events) > 2000:
                raise UnsureError("too many events")
        return self

    def _arc(self, stop):
        if stop <= self.t + SAME_TIME:
            return
        began, fresh = self.t, {label for label, u in self._numbers(self.z, self.t).items() if abs(u) < GRAZING}
        fresh |= {i.name for i in self.impacts if self._impact_numbers(self.z, self.t).get(i.name, 1.0) ** 2 < 1e-18}
        solver = DOP853(
            self._field,
            self.t,
            self.z,
            stop,
            rtol=RTOL * self.accuracy,
            atol=ATOL * self.accuracy,
            max_step=min(0.2, self.tau or 0.2),
            first_step=min(1e-2, stop - self.t),
        )
        while solver.status == "running":
            if solver.step():
                raise UnsureError("no step is small enough")
            if np.max(np.abs(solver.y)) > LARGE:
                raise UnsureError("states without bound")
            dense = solver.dense_output()
            self.edges.append(solver.t_old)
            self.pieces.append(dense)
            found = self._first(dense, solver.t_old, solver.t, began, fresh)
            if found is not None:
                t, what = found
                self.slid += (t - began) if self.on else 0.0
                self.t, self.z = t, dense(t)
                self._happen(what)
                return
        self.slid += (solver.t - began) if self.on else 0.0
        self.t, self.z = stop, solver.y

    def _impact_numbers(self, z, t):
        values = self._evaluate(self._values(np.asarray(z).tolist(), float(t)))[self.n :]
        return {i.name: u for i, u in zip(self.impacts, values, strict=True) if i.text}

    def _functions(self):
        """Return what may end an arc: (what, function, direction of its passing zero)."""
        result = []
        numbers = self._numbers(self.z, self.t)
        for label in numbers:
            if label in self.on:
                for place, direction in ((1, 1), (0, -1)):
                    result.append(
                        (
                            (label, "off", direction),
                            lambda z, t, k=label, i=place: self._end_rates(z, t, k)[i],
                            direction,
                        )
                    )
            else:
                up = self.flags[label]
                result.append(((label, "through", 0), lambda z, t, k=label: self._numbers(z, t)[k], -1 if up else 1))
        for impact in self.impacts:
            if impact.text:
                for direction in (1, -1):
                    if impact.direction in (0, direction):
                        result.append(
                            (
                                (impact.name, "jump", direction),
                                lambda z, t, k=impact.name: self._impact_numbers(z, t)[k],
                                direction,
                            )
                        )
        return result

    def _first(self, dense, first, last, began, fresh):
        """Return the first event in a step, as (time, what)."""
        found = []
        for what, function, direction in self._functions():
            start = first
            if what[0] in fresh or what[1] == "off":
                start = max(first, began + LATER)
                if start >= last:
                    continue
            times = start + (last - start) * SAMPLES

            def g(t, function=function, direction=direction):
                return direction * function(dense(t), t)

            values = np.array([g(t) for t in times])
            if what[1] != "jump" and values[0] > GRAZING:
                if what[0] in self.fixed and what[0] in fresh:
                    # It passed zero just where the arc before ended, as delayed values do at breaking points.
                    return began, what
                raise UnsureError(f"{what} is beyond its surface already")
            up = np.flatnonzero((values[:-1] <= 0.0) & (values[1:] > 0.0))
            tops = [
                i
                for i in range(1, len(values) - 1)
                if values[i] <= 0.0 and values[i] >= values[i - 1] and values[i] >= values[i + 1]
            ]
            near = [i for i in tops if -values[i] < 4.0 * max(values[i] - values[i - 1], values[i] - values[i + 1])]
            for i in near:
                top = minimize_scalar(
                    lambda t: -g(t), bounds=(times[i - 1], times[i + 1]), method="bounded", options={"xatol": 1e-9}
                )
                if abs(top.fun) < GRAZING and what[0] not in self.fixed:
                    raise UnsureError(f"{what} grazes")
                if top.fun < 0:
                    found.append((brentq(g, times[i - 1], top.x, xtol=1e-14), what))
            if len(up):
                i = up[0]
                found.append((brentq(g, times[i], times[i + 1], xtol=1e-14), what))
        return min(found, key=lambda f: f[0]) if found else None

    def _happen(self, what):
        name, kind, direction = what
        if kind == "jump":
            self._jump(next(i for i in self.impacts if i.name == name))
            return
        numbers = self._numbers(self.z, self.t)
        if kind == "off":
            self.on = tuple(o for o in self.on if o != name)
            self.flags = {**self.flags, name: direction > 0}
            self._note(name)
            return
        up = not self.flags[name]
        zero = {k for k, u in numbers.items() if abs(u) < ON_SURFACE and k not in self.relays} - set(self.on) | {name}
        others = {k for k in zero if k != name and k in self.fixed}
        self.flags = {**self.flags, name: up, **{k: not self.flags[k] for k in others}}
        self._note(name)
        zero = {k for k in zero if k not in self.fixed and k not in self.relays}
        # What slides elsewhere may be thrown off by the change.
        self._decide(zero | set(self.on))
        for impact_name, u in self._impact_numbers(self.z, self.t).items():
            if abs(u) < ON_SURFACE:
                raise UnsureError(f"jump {impact_name} at another event")
        self._nested(zero)

    def _nested(self, zero):
        """Read signs that changed because the numbers they belong to hold the flag that did."""
        for label, u in self._numbers(self.z, self.t).items():
            if label in zero or label in self.on or label in self.fixed or label in self.relays:
                continue
            if abs(u) > ON_SURFACE and (u > 0) != self.flags[label]:
                self.flags = {**self.flags, label: u > 0}
