"""Delay equations with a Hopf point: as models, and once more as Python functions for independent calculations."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mpmath import mp, mpf

from tests.equilibrium.harmonic_balance import integrate


@dataclass(frozen=True)
class HopfModel:
    """A model whose parameter ``free`` passes a Hopf point near ``near``, and its equations ``field(read, p)``.

    ``states`` and ``frequency`` are those of the point, roughly; ``start`` is the parameter where branches begin, and
    ``range_`` where they end.
    """

    model: dict[str, Any]
    field: Callable
    free: str
    near: float
    states: list[float]
    frequency: float
    start: float
    range_: tuple[float, float]


def _model(name, parameters, equations):
    return {"name": name, "states": list(equations), "parameters": parameters,
            "modes": {"m": {f"{s}'": text for s, text in equations.items()}},
            "initial": dict.fromkeys(equations, 0.1)}  # fmt: skip


WRIGHT = HopfModel(
    _model("wright", {"r": 1.5, "tau": 1}, {"x": "-r*x(t - tau)*(1 + x)"}),
    lambda read, r: [-r * read(0, 1) * (1 + read(0, 0))],
    "r", 1.57, [0.0], 1.57, 1.5, (1.4, 1.7),
)  # fmt: skip


def _mackey_glass(read, tau):
    ago = read(0, tau)
    return [2 * ago / (1 + ago**7) - mpf(13) / 10 * read(0, 0)]


MACKEY_GLASS = HopfModel(
    _model("mackey", {"tau": 0.8}, {"x": "2*x(t - tau)/(1 + x(t - tau)**7) - 1.3*x"}),
    _mackey_glass, "tau", 1.7, [0.915], 1.36, 1.4, (1.2, 2.2),
)  # fmt: skip


def _neurons(read, a):
    k, beta, s, one, other = mpf(1) / 2, mpf(-1), mpf(3) / 2, mpf(1) / 5, mpf(2) / 5
    return [
        -k * read(0, 0) + beta * mp.tanh(read(0, s)) + mp.tanh(read(1, other)) + mpf(3) / 10,
        -k * read(1, 0) + beta * mp.tanh(read(1, s)) + a * mp.tanh(read(0, one)) - mpf(1) / 10,
    ]


NEURONS = HopfModel(
    _model(
        "neurons",
        {"a": 0.5, "s": 1.5, "one": 0.2, "other": 0.4},
        {
            "x": "-0.5*x - tanh(x(t - s)) + tanh(y(t - other)) + 0.3",
            "y": "-0.5*y - tanh(y(t - s)) + a*tanh(x(t - one)) - 0.1",
        },
    ),
    _neurons, "a", -0.16, [0.15, -0.08], 1.29, 0.0, (-1.0, 0.5),
)  # fmt: skip


def _predators(read, tau):
    x, y = read(0, 0), read(1, 0)
    ago = read(0, 1)
    return [x * (1 - read(0, tau)) - x * y / (1 + x), 3 * ago * read(1, 1) / (1 + ago) - y]


PREDATORS = HopfModel(
    _model(
        "predators",
        {"tau": 0.4, "one": 1},
        {
            "x": "x*(1 - x(t - tau)) - x*y/(1 + x)",
            "y": "3*x(t - one)*y(t - one)/(1 + x(t - one)) - y",
        },
    ),
    _predators, "tau", 1.48, [0.5, 0.75], 0.64, 1.0, (0.5, 2.0),
)  # fmt: skip


def _van_der_pol(read, k):
    x, v, ago = read(0, 0), read(1, 0), read(0, 2)
    return [v, -x + mpf(1) / 5 * (1 - x**2) * v + k * (ago + mpf(1) / 2 * ago**2) - mpf(1) / 10 * read(1, 1) * x]


VAN_DER_POL = HopfModel(
    _model(
        "van_der_pol",
        {"k": 0.5, "tau": 2, "one": 1},
        {"x": "v", "v": "-x + 0.2*(1 - x**2)*v + k*(x(t - tau) + 0.5*x(t - tau)**2) - 0.1*v(t - one)*x"},
    ),
    _van_der_pol, "k", 0.25, [0.0, 0.0], 1.064, 0.6, (0.0, 0.9),
)  # fmt: skip
ALL = {"wright": WRIGHT, "mackey_glass": MACKEY_GLASS, "neurons": NEURONS, "predators": PREDATORS,
       "van_der_pol": VAN_DER_POL}  # fmt: skip


def _moving_lag(read, a):
    return [mpf(1) / 2 - a * read(0, 1 + mpf(3) / 10 * read(0, 0)) * (1 + mpf(1) / 5 * read(0, 0))]


STATE_DEPENDENT = HopfModel(
    _model("state_dependent", {"a": 1.5, "c": 0.3}, {"x": "0.5 - a*x(t - 1 - c*x)*(1 + 0.2*x)"}),
    _moving_lag, "a", 1.3, [0.36], 1.41, 1.2, (1.0, 1.8),
)  # fmt: skip


def _nested(read, a):
    x, y = read(0, 0), read(1, 0)
    inner = read(0, mpf(1) / 2 + mpf(1) / 5 * y**2)
    return [
        mpf(3) / 10 - a * mp.tanh(read(0, 1 + mpf(3) / 10 * inner)) + mpf(1) / 5 * y,
        -y + x * read(0, mpf(7) / 10 * mp.exp(-y)) + mpf(1) / 5,
    ]


NESTED = HopfModel(
    _model(
        "nested",
        {"a": 1.3, "b": 0.5},
        {
            "x": "0.3 - a*tanh(x(t - 1 - 0.3*x(t - b - 0.2*y**2))) + 0.2*y",
            "y": "-y + x*x(t - 0.7*exp(-y)) + 0.2",
        },
    ),
    _nested, "a", 1.55, [0.22, 0.25], 1.45, 1.2, (1.0, 2.0),
)  # fmt: skip


def _neutral(read, a):
    x = read(0, 0)
    return [-a * read(0, 1) * (1 + x) + mpf(2) / 5 * read(0, 1, 1) * (1 + read(0, mpf(1) / 2)) + mpf(1) / 5]


NEUTRAL = HopfModel(
    _model(
        "neutral",
        {"a": 1.0, "tau": 1, "half": 0.5},
        {"x": "0.2 - a*x(t - tau)*(1 + x) + 0.4*x'(t - tau)*(1 + x(t - half))"},
    ),
    _neutral, "a", 1.0, [0.17], 1.1, 0.8, (0.6, 1.6),
)  # fmt: skip


def _moving_neutral(read, a):
    x = read(0, 0)
    lag = 1 + mpf(3) / 10 * x
    return [mpf(1) / 5 - a * read(0, lag) * (1 + x) - mpf(3) / 10 * read(0, lag + read(0, 1) ** 2, 1)]


MOVING_NEUTRAL = HopfModel(
    _model(
        "moving_neutral",
        {"a": 1.5, "c": 0.3, "tau": 1},
        {"x": "0.2 - a*x(t - 1 - c*x)*(1 + x) - c*x'(t - 1 - c*x - x(t - tau)**2)"},
    ),
    _moving_neutral, "a", 1.6, [0.11], 1.6, 1.2, (1.0, 2.5),
)  # fmt: skip


def _spread(read, a):
    def kernel(s):
        x = read(0, s)
        return mp.exp(-s / 2) * (x + x**2 / 2 - x**3 / 3)

    return [mpf(3) / 10 - a * integrate(kernel, mpf(0), mpf(1)) * (1 + read(0, 0) / 4)]


DISTRIBUTED = HopfModel(
    _model(
        "distributed",
        {"a": 4.0, "q": 0.5, "far": 1},
        {"x": "0.3 - a*integral(exp(-q*s)*(x(t - s) + x(t - s)**2/2 - x(t - s)**3/3), s, 0, far)*(1 + 0.25*x)"},
    ),
    _spread, "a", 6.0, [0.06], 3.1, 4.0, (3.0, 8.0),
)  # fmt: skip


def _moving_limits(read, a):
    x, y = read(0, 0), read(1, 0)
    low = mpf(1) / 5 * mp.exp(x)
    window = integrate(
        lambda s: (1 + s / 2) * mp.sin(read(0, s)) * (1 + read(1, s)), low, 1 + y + read(0, mpf(1) / 2) / 4
    )
    slow = integrate(lambda s: read(0, s) ** 2, mpf(0), 1 + read(0, mpf(1) / 2 + read(1, 1)) / 3)
    return [mpf(3) / 10 - a * window, -y + slow / 2]


MOVING_LIMITS = HopfModel(
    _model(
        "moving_limits",
        {"a": 2.0, "b": 0.5},
        {
            "x": "0.3 - a*integral((1 + s/2)*sin(x(t - s))*(1 + y(t - s)), s, 0.2*exp(x), 1 + y + 0.25*x(t - b))",
            "y": "-y + 0.5*integral(x(t - v)**2, v, 0, 1 + x(t - b - y(t - 1))/3)",
        },
    ),
    _moving_limits, "a", 3.0, [0.1, 0.05], 2.6, 2.5, (2.0, 5.0),
)  # fmt: skip
OF_EVERY_KIND = {"state_dependent": STATE_DEPENDENT, "nested": NESTED, "neutral": NEUTRAL,
                 "moving_neutral": MOVING_NEUTRAL, "distributed": DISTRIBUTED,
                 "moving_limits": MOVING_LIMITS}  # fmt: skip
