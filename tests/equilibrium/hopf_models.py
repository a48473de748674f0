"""Delay equations with a Hopf point: as models, and once more as Python functions for independent calculations."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mpmath import mp, mpf


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
