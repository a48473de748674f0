"""Which expression has no finite value along an orbit, and where."""

import re

import numpy as np
import pytest

from pddecont.collocation import Mesh, equal_cuts
from pddecont.delay import Direct
from pddecont.errors import ConvergenceError
from pddecont.orbit import Orbit, OrbitProblem, PeriodicOrbitSystem, Signature, measure_orbit
from pddecont.orbit.nonfinite import explain_not_finite
from tests.conftest import numeric_from
from tests.orbits import segment_pieces

MODEL = """
name: m
states: [x]
parameters: {{p: {p}, tau: 1}}
modes: {{walk: {{x': {rate}}}}}
events: {{e: {event}}}
resets: {{back: {{x: {reset}}}}}
segments: {{s: {{mode: walk, event: e, reset: back, to: walk}}}}
"""


def orbit_of(rate="1", event="x", reset="0", p=1.0, free=()):
    """Return unknowns with x = 0.5 on a period of 2."""
    numeric = numeric_from(MODEL.format(rate=rate, event=event, reset=reset, p=p))
    mesh = Mesh(3, 1, segment_pieces(1, 1 + len(numeric.model.delays), equal_cuts([4])))
    signature = Signature(numeric, (numeric.model.segments["s"],))
    problem = OrbitProblem(signature, mesh, Direct(), numeric.parameter_values, free)
    x = problem.unknowns.join(np.full((mesh.n_base, 1), 0.5), [2.0], 0.0, problem.parameters[list(problem.free_index)])
    return Orbit(problem, x)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"rate": "sqrt(p - 2) - x"}, r"sqrt\(p - 2\) takes a root of a negative number \(-1\) in x' of mode 'walk'"),
        ({"rate": "1/(x - 0.5)"}, r"divides by zero in x' of mode 'walk'"),
        ({"rate": "log((x(t - tau) - 0.5)**30)"}, r"takes the logarithm of zero in x' of mode 'walk'"),
        (
            {"reset": "log(x - 1)"},
            r"log\(x - 1\) takes the logarithm of a negative number \(-0\.5\) in x of reset 'back'",
        ),
        ({"event": "sqrt(x - 1)"}, r"sqrt\(x - 1\) takes a root of a negative number \(-0\.5\) in event 'e'"),
    ],
)
def test_the_expression_is_named(parts, message):
    assert re.search(message, explain_not_finite(orbit_of(**parts)))


def test_a_derivative_without_a_value():
    """sqrt(p) is zero at p = 0, its slope there is not."""
    orbit = orbit_of(rate="sqrt(p) - x", p=0.0, free=("p",))
    text = explain_not_finite(orbit, derivatives=True)
    assert "in the derivative of x' of mode 'walk' in p" in text
    assert explain_not_finite(orbit) == "the orbit's equations have no finite values here"


def test_the_system_refuses_with_the_same_words():
    orbit = orbit_of(rate="sqrt(p - 2) - x")
    with pytest.raises(ConvergenceError, match=r"sqrt\(p - 2\) takes a root"):
        _ = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit)).at(orbit.x).residual
    orbit = orbit_of(rate="sqrt(p) - x", p=0.0, free=("p",))
    with pytest.raises(ConvergenceError, match="in the derivative of x' of mode 'walk' in p"):
        PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, (1.0,))).at(orbit.x).jacobian()
