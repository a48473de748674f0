"""Terms that read the past by a lag that varies, as a rate, or as an integral, in both spellings of a formula.

In Python, ``read(lag, order)`` is the states' values or rates a lag ago, ``integrate(g, low, high)`` the integral of
g(s, states at t - s), ``remember(g, rate, low)`` that of rate exp(-rate (s - low)) g(states at t - s) from low on.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.random_models.draw import Draw
from tests.random_models.formula import Formula, States, call, name


@dataclass
class Parts:
    """What terms are drawn with: random numbers, the states, parameters so far, whether time may stand in lags.

    ``kinds`` collects the kinds of term drawn. ``remembers`` is whether integrals over all the past may be among them:
    the calculation apart has them for smooth motions of a period that is known.
    """

    draw: Draw
    states: States
    parameters: dict[str, float]
    forced: bool
    remembers: bool
    kinds: list[str] = field(default_factory=list)

    def add(self, stem, value):
        """Return the formula of a new parameter."""
        number = 1 + sum(p.startswith(stem) for p in self.parameters)
        self.parameters[f"{stem}{number}"] = value
        return name(f"{stem}{number}")

    def one_state(self):
        """Return the name of one of the states."""
        return self.draw.one_of(list(self.states.names))


def read_late(parts, state, lag, order=0):
    """Return a state, or its rate, a lag ago."""
    i = parts.states.names.index(state)
    return Formula(f"{state}{order * chr(39)}(t - {lag.yaml})", f"read({lag.python}, {order})[{i}]")


def draw_lag(parts, low=0.3, high=2.0, kind=None):
    """Return a lag that varies by less than half of what it is at rest."""
    draw, value = parts.draw, parts.draw.between(low, high)
    tau = parts.add("tau", value)
    kinds = ["by a state", "by a state", "nested", *(["in time"] if parts.forced else [])]
    kind = draw.one_of(kinds) if kind is None else kind
    parts.kinds.append(kind)
    share = parts.add("q", round(draw.signed(0.1, 0.45) * value, 4))
    if kind == "by a state":
        moved = call("tanh", parts.states[parts.one_state()])
    elif kind == "nested":
        moved = call("tanh", read_late(parts, parts.one_state(), parts.add("tau", draw.between(low, high))))
    else:
        moved = call("cos", name("omega") * name("t") + draw.between(0.0, 6.0))
    return tau + share * moved


def varying(parts, gain):
    """Return a state at a lag that varies."""
    value = read_late(parts, parts.one_state(), draw_lag(parts))
    return gain * (call("tanh", 2 * value) if parts.draw.chance(0.3) else value)


def neutral(parts, gain):
    """Return a rate at a lag that is constant or varies."""
    parts.kinds.append("neutral")
    lag = draw_lag(parts) if parts.draw.chance(0.5) else parts.add("tau", parts.draw.between(0.3, 2.0))
    return gain * read_late(parts, parts.states.names[-1], lag, 1)


def distributed(parts, gain):
    """Return an integral over lags between limits that are constant or vary."""
    draw, state = parts.draw, parts.one_state()
    parts.kinds.append("distributed")
    i = parts.states.names.index(state)
    low = as_limit(draw, parts)
    width = parts.add("w", draw.between(0.3, 1.2))
    high = low + width
    if draw.chance(0.4):
        parts.kinds.append("limit that varies")
        high = high + parts.add("q", draw.signed(0.05, 0.25)) * call("tanh", parts.states[parts.one_state()])
    kernel = parts.add("k", draw.between(0.2, 1.0))
    inside = f"{state}(t - s)" if draw.chance(0.5) else f"tanh({state}(t - s))"
    written = f"integral(exp(-{kernel.yaml}*s)*{inside}, s, {low.yaml}, {high.yaml})"
    seen = f"u[{i}]" if inside.endswith("s)") and not inside.startswith("tanh") else f"tanh(u[{i}])"
    python = f"integrate(lambda s, u: exp(-{kernel.python}*s)*{seen}, {low.python}, {high.python})"
    return gain * Formula(written, python)


def as_limit(draw, parts):
    """Return where an integral begins: at once, or at a lag."""
    return Formula("0", "0") if draw.chance(0.4) else parts.add("low", draw.between(0.2, 1.0))


def remembered(parts, gain):
    """Return an integral over all the past with an exponential kernel."""
    draw, state = parts.draw, parts.one_state()
    parts.kinds.append("remembered")
    i, rate = parts.states.names.index(state), parts.add("k", draw.between(0.5, 2.0))
    low = as_limit(draw, parts)
    written = f"integral({rate.yaml}*exp(-{rate.yaml}*(s - {low.yaml}))*{state}(t - s), s, {low.yaml}, inf)"
    return gain * Formula(written, f"remember(lambda u: u[{i}], {rate.python}, {low.python})")


def draw_terms(parts, low=0.05, high=0.25):
    """Return the sum of one to three terms, each of a kind drawn."""
    kinds = [varying, varying, neutral, distributed, *([remembered] if parts.remembers else [])]
    total = None
    for _ in range(parts.draw.one_of([1, 1, 2, 3])):
        term = parts.draw.one_of(kinds)(parts, parts.add("K", parts.draw.signed(low, high)))
        total = term if total is None else total + term
    return total
