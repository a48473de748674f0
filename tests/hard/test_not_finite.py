"""Overflow and values that do not exist.

Each ends the branch, or the simulation, with the expression that fails and the point at which it does.
"""

import re

import pytest

from pddecont.errors import ConvergenceError, PddecontError
from pddecont.tables import describe_endings
from tests.runs import change, parameter, run


def model(rate, start=1, ends=(0, 1), way="up"):
    """Return a model with y' = ``rate``, and a run that follows its orbit in p from ``start`` to one of ``ends``."""
    branch = {"from": "o", "free": ["p"], "range": {"p": [*ends]}, "direction": way}
    return {
        "name": "m",
        "states": ["x", "y"],
        "parameters": {"p": start, "eps": 0.1},
        "forcing": {"period": "2*pi"},
        "modes": {"walk": {"x'": "cos(t) - x + 0.1*y", "y'": rate}},
        "run": {
            "mesh": {"degree": 6, "intervals": 8},
            "steps": [
                {"name": "t", "simulate": {"t_end": 120}},
                {"name": "o", "orbit": {"from": "t"}},
                {"name": "c", "continue": branch},
            ],
        },
    }


CASES = {
    "exp of a large number": (
        "exp(p)/(1 + exp(p)) - y",
        1,
        0,
        2000,
        "up",
        r"exp\(2\*p\) overflows in the derivative of y' of mode 'walk' in p, at t = [\d.e-]+, p = 3\d\d",
        354.891,
    ),
    "root of a negative number": (
        "sqrt(p)*cos(t) - y",
        1,
        -1,
        1,
        "down",
        r"sqrt\(p\) takes a root of a negative number \(-[\d.e-]+\) in y' of mode 'walk', at t = .*, p = -",
        0.0,
    ),
    "root of a state": (
        "sqrt(p + x) - y",
        2,
        0,
        2,
        "down",
        r"sqrt\(p \+ x\) takes a root of a negative number \(-[\d.e-]+\) in y' .*, x = -0\.\d+, p",
        None,
    ),
    "logarithm of a negative number": (
        "1.0e-9*log(p) - y",
        1,
        -1,
        1,
        "down",
        r"log\(p\) takes the logarithm of a negative number",
        0.0,
    ),
    "inverse sine beyond one": ("asin(p) - y", 0.5, 0, 2, "up", r"asin\(p\) is not defined at 1\.0000\d+ in y\'", 1.0),
}


@pytest.mark.parametrize("case", CASES)
def test_branches_end_with_the_expression_and_the_point(tmp_path, case, record):
    rate, start, low, high, way, message, edge = CASES[case]
    step = run(model(rate, start, (low, high), way), tmp_path / "a.h5").step("c")
    ending = describe_endings(step)[0]
    assert re.search(message, ending), ending
    p = parameter(step, "p")
    last = p[0] if way == "down" else p[-1]
    if edge is not None:
        # As near as the smallest step, in units of the parameter's range.
        record(
            f"{case}: how near the branch comes, of its range",
            "where the value ceases",
            abs(last - edge) / (high - low),
            2e-3,
        )


@pytest.mark.parametrize(
    ("rate", "message"),
    [
        ("sqrt(0.5 - y)", r"sqrt\(0\.5 - y\) takes a root of a negative number"),
        (
            "1/(0.5 - y)",
            r"near t = 0\.125 in mode 'walk': the solution grows without bound there, or the vector field has a "
            r"singularity",
        ),
        ("2 - log(0.5 - y)", r"log\(0\.5 - y\) takes the logarithm of (a negative number|zero)"),
        ("exp(2000*t)/(1 + exp(2000*t)) - y", r"exp\(2000\*t\) overflows in y' of mode 'walk', at t = 0\.354"),
        ("1 + y**2", r"grows without bound"),
    ],
)
def test_simulations_end_with_the_expression_and_the_point(tmp_path, rate, message, record):
    with pytest.raises(ConvergenceError) as failure:
        run(model(rate), tmp_path / "a.h5")
    assert re.search(message, str(failure.value))
    record(f"simulation of y' = {rate}", "refused, by name and place", 0, 0)


@pytest.mark.parametrize(
    ("rate", "message"),
    [("log(p) - y", r"log\(p\) takes the logarithm of zero"), ("1 - y - x/p", "1/p divides by zero")],
)
def test_an_orbit_whose_guess_has_no_value(tmp_path, rate, message, record):
    with pytest.raises(PddecontError, match=message + r" in y' of mode 'walk', at t = [\d.e-]+, p = 0"):
        run(change(model(rate), "run.steps.1.set", {"p": 0}), tmp_path / "a.h5")
    record(f"orbit step where y' = {rate} has no value", "refused, by name and place", 0, 0)
