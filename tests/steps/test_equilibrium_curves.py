"""Points of codimension two on curves of folds and Hopf points, of ordinary and delay equations, in closed form."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from tests.runs import labels, parameter, run


@dataclass(frozen=True)
class Case:
    """A model with a point of codimension two at ``place``, found on curves that begin at points ``starts``.

    The equilibrium near ``rest`` is followed in ``along``, the first free parameter, over its range. ``states`` and
    ``frequencies`` are those of the point, the latter on Hopf curves.
    """

    label: str
    equations: dict[str, str]
    parameters: dict[str, float]
    rest: dict[str, float]
    along: str
    ranges: dict[str, tuple[float, float]]
    starts: tuple[str, ...]
    place: dict[str, float]
    states: dict[str, float]
    frequencies: tuple[float, ...] = ()
    n_unstable: int = 0
    start_values: dict[str, float] = field(default_factory=dict)


# Equilibria of x' = g(x) + ... where g' = g'' = 0.
CUSP = Case(
    "CP",
    {"x": "(a - 0.2) + (b - 0.5)*x - x**3 + y", "y": "-2*y"},
    {"a": -1.0, "b": 1.5},
    {"x": -1.4, "y": 0},
    "a",
    {"a": (-3, 3), "b": (-1, 2)},
    ("LP1",),
    {"a": 0.2, "b": 0.5},
    {"x": 0, "y": 0},
)
# g = a + (b - 1) x + x^2 - x^3: x = 1/3.
CUSP_DELAYED = Case(
    "CP",
    {"x": "-x + a + b*x(t - tau) + x*x(t - tau) - x(t - tau)**3"},
    {"a": -1.0, "b": 1.5, "tau": 0.4},
    {"x": -1.0},
    "a",
    {"a": (-2, 2), "b": (0, 2)},
    ("LP1",),
    {"a": 1 / 27, "b": 2 / 3},
    {"x": 1 / 3},
)
# Folds a = b^2/4 with x = -b/2, Hopf points x = -c.
TAKENS = Case(
    "BT",
    {"x": "y", "y": "a + b*x + c*y + x**2 + x*y"},
    {"a": -0.5, "b": 0.2, "c": 0.5},
    {"x": -0.81, "y": 0},
    "a",
    {"a": (-2, 2), "b": (-2, 3)},
    ("LP1", "HB1"),
    {"a": 0.25, "b": 1.0},
    {"x": -0.5, "y": 0},
    (0.0,),
)
# lambda = A + B exp(-lambda tau) has a double root zero where B = -1/tau = -A: with B = c x - 1, A = b + 2 x + c x.
TAKENS_DELAYED = Case(
    "BT",
    {"x": "a + b*x + x**2 + c*x*x(t - tau) - x(t - tau)"},
    {"a": 1.0, "b": -2.5, "c": 0.5, "tau": 2.0},
    {"x": 0.32},
    "a",
    {"a": (-1, 4), "b": (-5, 1)},
    ("LP1",),
    {"a": 1.5, "b": -2.0},
    {"x": 1.0},
    (0.0,),
)
# y and z turn and grow with b - x, x has its fold at a = 0.
ZERO_HOPF = Case(
    "ZH",
    {
        "x": "a - (x - 1)**2 - y**2 - z**2",
        "y": "(b - x)*y - 2*z - y*(y**2 + z**2)",
        "z": "2*y + (b - x)*z - z*(y**2 + z**2)",
    },
    {"a": 0.5, "b": 1.3},
    {"x": 1.7, "y": 0, "z": 0},
    "a",
    {"a": (-1, 2), "b": (-1, 3)},
    ("LP1", "HB1"),
    {"a": 0.0, "b": 1.0},
    {"x": 1, "y": 0, "z": 0},
    (2.0,),
)
# lambda^2 + c lambda + K = b exp(-lambda tau), K = k + 2 x = b for the root zero; with omega = 2, tau = 2 the pair.
_B = 4 / (1 - math.cos(4))
ZERO_HOPF_DELAYED = Case(
    "ZH",
    {"x": "v", "v": "a - c*v - k*x + b*x(t - tau) - x**2"},
    {"a": 0.0, "b": 2.2, "k": 1.0, "tau": 2.0, "c": -_B * math.sin(4) / 2},
    {"x": 1.2, "v": 0},
    "a",
    {"a": (-2, 2), "b": (1, 4)},
    ("LP1", "HB1"),
    {"a": -((_B - 1) ** 2) / 4, "b": _B},
    {"x": (_B - 1) / 2, "v": 0},
    (2.0,),
)
# Two oscillators of frequencies 1 and w.
DOUBLE_HOPF = Case(
    "HH",
    {
        "x": "(a - 0.1)*x - y - x*(x**2 + y**2) - 1.5*x*(u**2 + v**2)",
        "y": "x + (a - 0.1)*y - y*(x**2 + y**2) - 1.5*y*(u**2 + v**2)",
        "u": "(b + 0.2)*u - w*v - u*(u**2 + v**2) - 0.5*u*(x**2 + y**2)",
        "v": "w*u + (b + 0.2)*v - v*(u**2 + v**2) - 0.5*v*(x**2 + y**2)",
    },
    {"a": -0.3, "b": -0.5, "w": math.sqrt(5)},
    {"x": 0, "y": 0, "u": 0, "v": 0},
    "a",
    {"a": (-1, 1), "b": (-1, 1)},
    ("HB1",),
    {"a": 0.1, "b": -0.2},
    {"x": 0, "y": 0, "u": 0, "v": 0},
    (1.0, math.sqrt(5)),
)
# k - omega^2 = b cos(omega tau), b sin(omega tau) = 0: with tau = pi k - 4 = b and k - 9 = -b.
DOUBLE_HOPF_DELAYED = Case(
    "HH",
    {"x": "v", "v": "-k*x + b*x(t - tau) - x**3"},
    {"b": 1.0, "k": 6.0, "tau": math.pi},
    {"x": 0, "v": 0},
    "b",
    {"b": (1, 4), "k": (5, 8)},
    ("HB1", "HB2"),
    {"b": 2.5, "k": 6.5},
    {"x": 0, "v": 0},
    (2.0, 3.0),
)
# r' = (b1 - 0.1) r + (b2 + 0.3) r^3 - r^5.
BAUTIN = Case(
    "GH",
    {
        "x": "(m - 0.1)*x - y + (n + 0.3)*x*(x**2 + y**2) - x*(x**2 + y**2)**2",
        "y": "x + (m - 0.1)*y + (n + 0.3)*y*(x**2 + y**2) - y*(x**2 + y**2)**2",
    },
    {"m": -0.3, "n": -0.8},
    {"x": 0, "y": 0},
    "m",
    {"m": (-1, 1), "n": (-1, 1)},
    ("HB1",),
    {"m": 0.1, "n": -0.3},
    {"x": 0, "y": 0},
    (1.0,),
)
# Wright's equation with k x^3: Re c1 = (3 k - (3 pi - 2) pi/20) / (1 + pi^2/4) at r tau = pi/2.
BAUTIN_DELAYED = Case(
    "GH",
    {"x": "-r*x(t - tau)*(1 + x) + k*x**3"},
    {"r": 1.2, "k": 0.1, "tau": 1.0},
    {"x": 0},
    "r",
    {"r": (1, 2), "k": (-1, 1)},
    ("HB1",),
    {"r": math.pi / 2, "k": (3 * math.pi - 2) * math.pi / 60},
    {"x": 0},
    (math.pi / 2,),
)
CASES = {
    name.lower(): value for name, value in list(globals().items()) if isinstance(value, Case) and name.isupper()
}


def make_run(case):
    """Return a run that follows the equilibrium and the curves of its special points."""
    first, second = case.ranges
    ranges = {name: list(bounds) for name, bounds in case.ranges.items()}
    curve = {"free": [first, second], "range": ranges}
    steps = [
        {"name": "rest", "equilibrium": {"from": case.rest}},
        {
            "name": "along",
            "continue": {"from": "rest", "free": [case.along], "range": {case.along: ranges[case.along]}},
        },
        *(
            {"name": start, "continue": {"from": {"step": "along", "point": start}, **curve}}
            for start in case.starts
        ),
    ]
    return {
        "name": "m",
        "states": list(case.equations),
        "parameters": case.parameters,
        "modes": {"m": {f"{name}'": text for name, text in case.equations.items()}},
        "initial": case.rest,
        "run": {"steps": steps},
    }


@pytest.mark.parametrize("name", CASES)
def test_the_point_is_where_the_closed_form_says(name, tmp_path):
    case = CASES[name]
    results = run(make_run(case), tmp_path / "r.h5")
    for start in case.starts:
        step = results.step(start)
        label = f"{case.label}1"
        print(name, start, labels(step))
        assert label in labels(step)
        row = step.row(label)
        for parameter_, value in case.place.items():
            print(parameter_, float(parameter(step, parameter_, label)) - value)
            assert parameter(step, parameter_, label) == pytest.approx(value, abs=1e-9)
        print(step.points["states"][row] - np.array(list(case.states.values())), step.points["frequency"][row])
        assert step.points["states"][row] == pytest.approx(list(case.states.values()), abs=1e-9)
        assert step.points["n_unstable"][row] == case.n_unstable
