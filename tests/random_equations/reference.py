"""Motions of laws with nonsmooth functions, independent of the package: flags, Filippov's rule, scipy's DOP853.

Between events the flags of all signs are held, so that the law is smooth; the numbers whose signs they are end the
arc where they pass zero. Delayed values are read from the dense output of steps that end at breaking points.

Where the rules do not decide, or where a number only just reaches zero, nothing is said: :class:`UnsureError`.
"""

from __future__ import annotations

import bisect
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import DOP853

from tests.random_equations.laws import Law
from tests.random_equations.sides import Sides, UnsureError
from tests.random_equations.zeros import GRAZING, find_first

RTOL, ATOL = 1e-11, 1e-13
# A number this near to zero at an event is zero.
ON_SURFACE = 1e-9
# Times closer than this are one.
SAME_TIME = 1e-10
ECHOES, LARGE = 3, 1e3


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
        law = Law([*self.texts, *(i.text or "0.0" for i in self.impacts)], self.names)
        self.sides = Sides(law, n, self.grips, self.relays, self.fixed)
        self.resets = {i.name: Law(i.reset, self.names) for i in self.impacts}
        self.n, self.t, self.z = n, 0.0, np.array(self.start, float)
        self.edges, self.pieces, self.events, self.pending = [], [], [], []
        self.breaks = [k * self.tau for k in range(1, ECHOES + 1)] if self.tau else []
        self.slid = 0.0
        self.sides.read_all(self._now)
        zero = {label for label, u in self._numbers(self.z, self.t).items() if abs(u) < ON_SURFACE}
        for label in zero & self.fixed:
            self.sides.flags[label] = self.sides.find_rate(label, self._now, np.zeros(n)) > 0
        self.sides.decide(self._now, zero - self.fixed - self.relays)

    def read(self, t):
        """Return the states at a time that is over."""
        if t <= 0.0 or not self.pieces:
            return np.asarray(self.start, float)
        return self.pieces[max(bisect.bisect_right(self.edges, t + SAME_TIME) - 1, 0)](t)

    def _values(self, z, t):
        past = self.read(t - self.tau) if self.tau else ()
        return [*z, t, *past]

    def _numbers(self, z, t):
        return self.sides.find_numbers(self._values(np.asarray(z).tolist(), float(t)))

    @property
    def _now(self):
        """What the law reads at the present time."""
        return self._values(self.z.tolist(), self.t)

    # What happens at an event.

    def _read_late(self):
        """Read the signs of delayed values where those may have jumped."""
        numbers = self._numbers(self.z, self.t)
        now = {k: numbers[k] > 0 for k in self.fixed if abs(numbers.get(k, 0.0)) > GRAZING}
        if any(self.sides.flags[k] != up for k, up in now.items()):
            self.sides.flags = self.sides.flags | now
            self._note("late")
            self.sides.decide(self._now, set(self.sides.on))

    def _reread(self):
        """Read the flags after the states have jumped."""
        on = set()
        for _ in range(8):
            numbers, now = self._numbers(self.z, self.t), {}
            for label, u in numbers.items():
                now[label] = u >= 0 if label in self.relays and self.sides.flags[label] else u > 0
                if label not in self.relays and label not in self.fixed and abs(u) < ON_SURFACE:
                    on.add(label)
                    now[label] = self.sides.flags[label]
                elif abs(u) < GRAZING and label not in self.fixed:
                    raise UnsureError("a jump almost onto a surface")
            if now == self.sides.flags:
                break
            self.sides.flags = now
        else:
            raise UnsureError("signs that depend on each other")
        self.sides.on = tuple(o for o in self.sides.on if o in on)
        if on:
            self.sides.decide(self._now, on)

    def _jump(self, impact):
        law = self.resets[impact.name]
        law.flags = self.sides.flags
        for label, wanted in impact.only:
            if label in self.sides.on or self.sides.flags[label] != wanted:
                return
        self.z = np.array(law.evaluate(*self._now), float)
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
            lambda t, z: self.sides.find_slopes(self._values(z.tolist(), float(t))),
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
            found = find_first(self._functions(), dense, (solver.t_old, solver.t), began, fresh, self.fixed)
            if found is not None:
                t, what = found
                self.slid += (t - began) if self.sides.on else 0.0
                self.t, self.z = t, dense(t)
                self._happen(what)
                return
        self.slid += (solver.t - began) if self.sides.on else 0.0
        self.t, self.z = stop, solver.y

    def _impact_numbers(self, z, t):
        values = self.sides.evaluate(self._values(np.asarray(z).tolist(), float(t)))[self.n :]
        return {i.name: u for i, u in zip(self.impacts, values, strict=True) if i.text}

    def _functions(self):
        """Return what may end an arc: (what, function, direction of its passing zero)."""
        result = []
        numbers = self._numbers(self.z, self.t)
        for label in numbers:
            if label in self.sides.on:
                for place, direction in ((1, 1), (0, -1)):
                    result.append(
                        (
                            (label, "off", direction),
                            lambda z, t, k=label, i=place: self.sides.find_end_rates(
                                self._values(np.asarray(z).tolist(), float(t)), k
                            )[i],
                            direction,
                        )
                    )
            else:
                up = self.sides.flags[label]
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

    def _happen(self, what):
        name, kind, direction = what
        if kind == "jump":
            self._jump(next(i for i in self.impacts if i.name == name))
            return
        numbers = self._numbers(self.z, self.t)
        if kind == "off":
            self.sides.on = tuple(o for o in self.sides.on if o != name)
            self.sides.flags = {**self.sides.flags, name: direction > 0}
            self._note(name)
            return
        up = not self.sides.flags[name]
        zero = {k for k, u in numbers.items() if abs(u) < ON_SURFACE and k not in self.relays} - set(self.sides.on) | {
            name
        }
        others = {k for k in zero if k != name and k in self.fixed}
        self.sides.flags = {**self.sides.flags, name: up, **{k: not self.sides.flags[k] for k in others}}
        self._note(name)
        zero = {k for k in zero if k not in self.fixed and k not in self.relays}
        # What slides elsewhere may be thrown off by the change.
        self.sides.decide(self._now, zero | set(self.sides.on))
        for impact_name, u in self._impact_numbers(self.z, self.t).items():
            if abs(u) < ON_SURFACE:
                raise UnsureError(f"jump {impact_name} at another event")
        self._nested(zero)

    def _nested(self, zero):
        """Read signs that changed because the numbers they belong to hold the flag that did."""
        for label, u in self._numbers(self.z, self.t).items():
            if label in zero or label in self.sides.on or label in self.fixed or label in self.relays:
                continue
            if abs(u) > ON_SURFACE and (u > 0) != self.sides.flags[label]:
                self.sides.flags = {**self.sides.flags, label: u > 0}
