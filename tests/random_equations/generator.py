"""Random models given by their equations, each written twice: as a model file says them, and for the reference."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

import numpy as np

from tests.random_equations.reference import Impact, Reference

COMPARED = {True: ">", False: "<"}


@dataclass
class RandomEquations:
    """A model file's mapping, and the arguments of its reference."""

    seed: int
    mapping: dict
    kinds: list[str]
    reference: dict

    def make_reference(self, accuracy=1.0, moved=0.0):
        """Return a new motion of the reference.

        ``moved`` is added to x at the start: speeds may start on a surface.
        """
        given = dict(self.reference)
        start = np.array(given.pop("start"), float)
        start[0] += moved
        return Reference(start=start, accuracy=accuracy, **given)


@dataclass
class Term:
    """A nonsmooth term in both spellings, and the kinds of functions in it."""

    yaml: str
    python: str


@dataclass
class _Draw:
    seed: int
    labels: dict[str, str] = field(default_factory=dict)
    relays: set[str] = field(default_factory=set)
    fixed: set[str] = field(default_factory=set)
    grips: dict[str, float] = field(default_factory=dict)
    kinds: list[str] = field(default_factory=list)

    def __post_init__(self):
        self.r = random.Random(self.seed)
        r = self.r
        self.n = r.choice((1, 2, 2, 2, 3))
        self.states = ("x", "v", "y")[: self.n]
        self.om = f"{r.uniform(0.7, 2.2):.3g}" if r.random() < 0.6 else None
        self.tau = float(f"{r.uniform(0.3, 1.5):.3g}") if r.random() < 0.35 else None

    def number(self, low, high):
        return f"{self.r.uniform(low, high):.3g}"

    # Arguments of nonsmooth functions: the file's text and Python's.

    def argument(self, *, sliding=False):
        """Return an argument as (text of the file, text of Python, whether it holds delayed values alone)."""
        r = self.r
        choices = ["x", "x", "sum"] if self.n > 1 else ["x", "x"]
        if self.n > 1:
            choices += ["v", "v"]
        if self.n > 2:
            choices += ["y", "y"]
        if self.om:
            choices += ["moving"]
        if self.tau and not sliding:
            choices += ["late", "late"]
        kind = r.choice(choices)
        c = r.choice(("0.2", "0.5", "-0.3", "0"))
        tail = "" if c == "0" else f" - {c}" if c[0] != "-" else f" + {c[1:]}"
        if kind == "sum":
            u = f"x + {r.choice(('0.5', '0.8'))}*v{tail}"
        elif kind == "moving":
            u = f"{'v' if self.n > 1 else 'x'} - 0.4*cos({self.om}*t)"
        elif kind == "late":
            return f"x(t - {self.tau}){tail}", f"x_tau{tail}", True
        else:
            u = f"{kind}{tail}"
        return u, u, False

    def label(self, python, late=False):
        """Return the label, quoted, of the sign of a text."""
        if late:
            self.fixed.add(python)
        return repr(python)

    def add_kind(self, kind):
        self.kinds.append(kind)

    # Terms.

    def term(self, equation):
        """Return a term for the right-hand side of an equation."""
        r = self.r
        kinds = ["sign", "sign", "heaviside", "abs", "max", "larger", "min", "clip", "deadzone", "deadzone3"]
        kinds += ["where", "where_and", "where_or", "hysteresis", "nested", "nested_abs", "product", "feedback"]
        if self.n > 1 and equation == "v":
            kinds += ["coulomb", "coulomb", "friction", "friction"]
        if self.om:
            kinds += ["mod", "square"]
        kind = r.choice(kinds)
        self.add_kind(kind)
        return getattr(self, f"_{kind}")(equation)

    def _friction(self, equation):
        belt = self.r.choice(("", " - 0.3"))
        m, u = self.number(0.2, 0.9), f"v{belt}"
        return Term(f"-{m}*sign({u})", f"-{m}*sign({self.label(u)}, {u})")

    def _feedback(self, equation):
        own = equation
        c, m = self.r.choice(("", " - 0.2")), self.number(0.3, 1.5)
        u = f"{own}{c}"
        return Term(f"-{m}*sign({u})", f"-{m}*sign({self.label(u)}, {u})")

    def _coulomb(self, equation):
        belt = self.r.choice((" - 0.15", " + 0.25"))
        u, k, ratio = f"v{belt}", self.number(0.2, 0.6), self.r.choice((1.3, 1.5))
        if u in self.grips or any(u == s for s in self.labels):
            ratio = self.grips.get(u, ratio)
        self.grips[u] = ratio
        return Term(f"-coulomb({u}, {k}, {ratio}*{k})", f"-{k}*sign({self.label(u)}, {u})")

    def _sign(self, equation):
        u, p, late = self.argument()
        m = self.number(-0.8, 0.4)
        return Term(f"{m}*sign({u})", f"{m}*sign({self.label(p, late)}, {p})")

    def _heaviside(self, equation):
        u, p, late = self.argument()
        m, other = self.number(-0.9, 0.5), self.r.choice(self.states)
        return Term(
            f"{m}*heaviside({u})*(1 - 0.3*{other})", f"{m}*heaviside({self.label(p, late)}, {p})*(1 - 0.3*{other})"
        )

    def _abs(self, equation):
        u, p, late = self.argument()
        m = self.number(-0.6, 0.4)
        return Term(f"{m}*abs({u})", f"{m}*absolute({self.label(p, late)}, {p})")

    def _max(self, equation):
        u, p, late = self.argument()
        m = self.number(-4.0, 0.4)
        return Term(f"{m}*max(0, {u})", f"{m}*ramp({self.label(p, late)}, {p})")

    def _two(self):
        a, pa, _ = self.argument(sliding=True)
        b = self.number(0.1, 0.9)
        other = self.r.choice(("t", *self.states)) if self.om else self.r.choice(self.states)
        second = f"{b}*cos({self.om}*t)" if other == "t" else f"{b}*sin({other} + 1.1)"
        return a, second, pa, second

    def _larger(self, equation):
        a, b, pa, pb = self._two()
        m = self.number(-0.9, 0.3)
        return Term(f"{m}*max({a}, {b})", f"{m}*larger({self.label(f'{pa} minus {pb}')}, {pa}, {pb})")

    def _min(self, equation):
        a, b, pa, pb = self._two()
        m = self.number(-0.9, 0.3)
        return Term(f"{m}*min({a}, {b})", f"{m}*smaller({self.label(f'{pa} minus {pb}')}, {pa}, {pb})")

    def _ends(self):
        s = self.r.choice(self.states)
        a = self.r.choice(("0.2", "0.5"))
        low, high = self.label(f"{s} + {a}"), self.label(f"{s} - {a}")
        return s, a, low, high

    def _clip(self, equation):
        s, a, low, high = self._ends()
        m = self.number(-1.5, 0.4)
        return Term(f"{m}*clip({s}, -{a}, {a})", f"{m}*clip({low}, {high}, {s}, -{a}, {a})")

    def _deadzone(self, equation):
        s, a, low, high = self._ends()
        m = self.number(-3.0, 0.3)
        return Term(f"{m}*deadzone({s}, {a})", f"{m}*deadzone({low}, {high}, {s}, -{a}, {a})")

    def _deadzone3(self, equation):
        s = self.r.choice(self.states)
        low, high = self.label(f"{s} + 0.3"), self.label(f"{s} - 0.5")
        m = self.number(-3.0, 0.3)
        return Term(f"{m}*deadzone({s}, -0.3, 0.5)", f"{m}*deadzone({low}, {high}, {s}, -0.3, 0.5)")

    def _where(self, equation):
        u, p, late = self.argument()
        a, b = self.number(-0.7, 0.7), f"0.4*{self.r.choice(self.states)}"
        greater = self.r.random() < 0.5
        condition = f"{u} {COMPARED[greater]} 0"
        first, second = (a, b) if greater else (b, a)
        return Term(f"-where({condition}, {a}, {b})", f"-({first} if up({self.label(p, late)}, {p}) else {second})")

    def _both(self):
        one, other = self.argument(), self.argument()
        while other[1] == one[1]:
            other = self.argument()
        return one, other

    def _where_and(self, equation):
        (u, pu, late_u), (w, pw, late_w) = self._both()
        a, b = self.number(-0.7, 0.7), self.number(-0.7, 0.7)
        first, second = f"up({self.label(pu, late_u)}, {pu})", f"up({self.label(pw, late_w)}, {pw})"
        # Both are read, so that both numbers are noted.
        return Term(f"where({u} > 0 and not {w} > 0, {a}, {b})", f"({a} if all([{first}, not {second}]) else {b})")

    def _where_or(self, equation):
        (u, pu, late_u), (w, pw, late_w) = self._both()
        a, b = self.number(-0.7, 0.7), self.number(-0.7, 0.7)
        first, second = f"up({self.label(pu, late_u)}, {pu})", f"up({self.label(pw, late_w)}, {pw})"
        return Term(f"where({u} > 0 or {w} > 0, {a}, {b})", f"({a} if any([{first}, {second}]) else {b})")

    def _hysteresis(self, equation):
        u = self.r.choice(self.states)
        low, high = self.r.choice((("-0.2", "0.2"), ("-0.1", "0.4")))
        m = self.number(-0.8, 0.3)
        label = f"relay {u} {low} {high}"
        self.relays.add(label)
        return Term(f"{m}*hysteresis({u}, {low}, {high})", f"{m}*relay({label!r}, {u}, {low}, {high})")

    def _nested(self, equation):
        s, e = self.r.choice(self.states), self.r.choice(("0.3", "0.6"))
        m = self.number(-3.0, 0.3)
        inner = f"absolute({self.label(s)}, {s})"
        u = f"{inner} - {e}"
        return Term(f"{m}*max(0, abs({s}) - {e})", f"{m}*ramp({self.label(f'nested {s} {e}')}, {u})")

    def _nested_abs(self, equation):
        s = self.r.choice(self.states)
        m = self.number(-0.7, 0.4)
        low, high = self.label(f"{s} + 0.5"), self.label(f"{s} - 0.5")
        inner = f"clip({low}, {high}, {s}, -0.5, 0.5)"
        return Term(f"{m}*abs(clip({s}, -0.5, 0.5) + 0.1)", f"{m}*absolute({self.label(f'clip {s}')}, {inner} + 0.1)")

    def _product(self, equation):
        s = "v" if self.n > 1 else "x"
        m, e = self.number(0.2, 0.8), self.r.choice(("0.2", "-0.4"))
        u = f"x - {e}" if e[0] != "-" else f"x + {e[1:]}"
        return Term(f"-{m}*sign({s})*max(0, {u})", f"-{m}*sign({self.label(s)}, {s})*ramp({self.label(u)}, {u})")

    def _time(self):
        a = self.r.choice((None, "0.7"))
        text = "t" if a is None else f"t - {a}"
        label = f"angle {text}"
        self.fixed.add(label)
        return text, label

    def _mod(self, equation):
        text, label = self._time()
        m = self.number(-0.3, 0.3)
        return Term(f"{m}*mod({text}, 2*pi/{self.om})", f"{m}*mod({label!r}, {text}, 2*pi/{self.om})")

    def _square(self, equation):
        text, label = self._time()
        m = self.number(-0.7, 0.7)
        return Term(f"{m}*square({text}, 2*pi/{self.om})", f"{m}*square({label!r}, {text}, 2*pi/{self.om})")


def draw_equations(seed):
    """Return the random model of a seed."""
    d = _Draw(seed)
    r = d.r
    base = {"x": f"0.3 - {d.number(0.4, 1.0)}*x"}
    if d.n > 1:
        base = {"x": "v", "v": f"-{d.number(0.8, 2.5)}*x - {d.number(0.1, 0.5)}*v"}
    if d.n > 2:
        base["y"] = f"{d.number(0.3, 1.0)}*x - {d.number(0.5, 1.2)}*y"
        base["v"] += f" - {d.number(0.1, 0.4)}*y"
    main = "v" if d.n > 1 else "x"
    if d.om:
        base[main] += f" + {d.number(0.4, 1.6)}*cos({d.om}*t)"
    yaml, python = dict(base), dict(base)
    if d.tau:
        k = d.number(-0.35, 0.35)
        yaml[main] += f" + {k}*x(t - {d.tau})"
        python[main] += f" + {k}*x_tau"
    for _ in range(r.choice((1, 2, 2, 3))):
        place = r.choice([main, main, d.states[-1]])
        term = d.term(place)
        yaml[place] += f" + {term.yaml}"
        python[place] += f" + {term.python}"
    start = [float(d.number(-1.0, 1.0)) for _ in d.states]
    if "coulomb" in d.kinds and r.random() < 0.3:
        start[1] = 0.15
    mapping = {"name": f"random_{seed}", "states": list(d.states), "parameters": {}}
    if d.om:
        mapping["forcing"] = {"period": f"2*pi/{d.om}"}
    mapping["equations"] = {f"{s}'": yaml[s] for s in d.states}
    jumps, impacts = _draw_jumps(d)
    if jumps:
        mapping["jumps"] = jumps
    mapping["initial"] = dict(zip(d.states, start, strict=True))
    reference = {
        "states": d.states,
        "texts": tuple(python[s] for s in d.states),
        "start": start,
        "tau": d.tau,
        "impacts": impacts,
        "grips": dict(d.grips),
        "relays": frozenset(d.relays),
        "fixed": frozenset(d.fixed),
    }
    return RandomEquations(seed, mapping, d.kinds, reference)


def _draw_jumps(d):
    r = d.r
    jumps, impacts = {}, []
    if d.n > 1 and r.random() < 0.35:
        d.add_kind("impact")
        at, e = d.number(0.3, 0.9), d.number(0.5, 0.9)
        reset = tuple(f"-{e}*v" if s == "v" else s for s in d.states)
        jumps["stop"] = {"at": f"x - {at}", "direction": "rising", "reset": {"v": f"-{e}*v"}}
        impacts.append(Impact("stop", f"x - {at}", 1, reset))
        if r.random() < 0.5:
            d.add_kind("kick")
            delay, size = d.number(0.2, 1.1), d.number(-0.5, 0.3)
            jumps["kick"] = {"after": "stop", "delay": float(delay), "reset": {"v": f"v + {size}"}}
            kicked = tuple(f"v + {size}" if s == "v" else s for s in d.states)
            impacts.append(Impact("kick", None, 0, kicked, "stop", float(delay)))
    if d.om and r.random() < 0.2:
        d.add_kind("dose")
        size, state = d.number(-0.4, 0.4), r.choice(d.states)
        period = f"2*pi/{d.om}"
        jumps["dose"] = {"every": period, "reset": {state: f"{state} + {size}"}}
        dosed = tuple(f"{state} + {size}" if s == state else s for s in d.states)
        impacts.append(Impact("dose", f"sin({d.om}*t)", 1, dosed))
    return jumps, tuple(impacts)
