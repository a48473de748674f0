"""All equilibria of modes in a box."""

import numpy as np
import pytest

from pddecont.codegen import NumericModel
from pddecont.delay import Direct
from pddecont.equilibrium import ConstantMotion, find_equilibria, find_passed_side
from pddecont.errors import ConvergenceError
from tests.runs import plan

CHUA = {
    "name": "chua",
    "states": ["x", "y", "z"],
    "parameters": {"alpha": 9.0, "beta": 14.28, "a": -8 / 7, "b": -5 / 7},
    "equations": {
        "x'": "alpha*(y - x - b*x - 0.5*(a - b)*(abs(x + 1) - abs(x - 1)))",
        "y'": "x - y + z",
        "z'": "-beta*y",
    },
}
RELAY = {
    "name": "relay",
    "states": ["x", "y"],
    "parameters": {"k": 2.0},
    "equations": {"x'": "-x + y - k*sign(x)", "y'": "-y + 1 - x"},
}
CROSSED = {
    "name": "crossed",
    "states": ["x", "y", "z"],
    "parameters": {"k": 2.0},
    "switches": {"p": "x + 0.1*z**2", "q": "y - x"},
    "equations": {"x'": "z - k*sign(x + 0.1*z**2)", "y'": "1 - z - k*sign(y - x)", "z'": "1 - z - z**3 + x + 0.5*y"},
}
DELAYED = {
    "name": "delayed",
    "states": ["x"],
    "parameters": {"b": 2.0, "g": 1.0, "n": 9.65, "tau": 2.0},
    "modes": {"m": {"x'": "b*x(t - tau)/(1 + x(t - tau)**n) - g*x"}},
    "initial": {"x": 0.5},
}
SHARED = {
    "name": "shared",
    "states": ["x", "v"],
    "parameters": {"e": 0.5},
    "modes": {"out": {"x'": "v", "v'": "-0.1*v - x*(x**2 - 1)"}, "in": {"x'": "v", "v'": "-0.1*v - x*(x**2 - 1)"}},
    "events": {"edge": "x - e"},
    "segments": {
        "enter": {"mode": "out", "event": "edge", "direction": "falling", "to": "in"},
        "leave": {"mode": "in", "event": "edge", "direction": "rising", "to": "out"},
    },
    "initial": {"mode": "out", "x": 1.0},
}


def search(model, low, high, modes=None):
    """Return what is found of a model in a box."""
    numeric = NumericModel(plan({**model, "run": {"steps": [{"name": "t", "simulate": {"t_end": 1}}]}}).model)
    motions = [ConstantMotion(numeric, mode, Direct()) for mode in modes or numeric.model.modes]
    return find_equilibria(motions, numeric.parameter_values, np.array(low, float), np.array(high, float))


def admissible(findings):
    """Return the states of the equilibria that lie in their mode, in order."""
    assert not findings.undecided
    return np.array(sorted(one.at.states.tolist() for one in findings.equilibria if find_passed_side(one.at) is None))


def test_chua_has_three_in_the_regions_of_its_diode():
    """(b + 1) x + (a - b) = 0 outside, on both sides: x = 1.5."""
    assert np.allclose(admissible(search(CHUA, [-5] * 3, [5] * 3)), [[-1.5, 0, 1.5], [0, 0, 0], [1.5, 0, -1.5]])


def test_a_relay_rests_on_its_surface_and_both_sides_have_virtual_ones():
    findings = search(RELAY, [-3, -3], [3, 3])
    assert np.allclose(admissible(findings), [[0, 1]], atol=1e-14)
    states = sorted((one.at.motion.mode, *one.at.states.round(12).tolist()) for one in findings.equilibria)
    assert [mode for mode, *_ in states] == ["x_above", "x_below", "x_on"]
    assert np.allclose([at for _, *at in states], [[-0.5, 1.5], [1.5, -0.5], [0, 1]], atol=1e-12)


def test_two_surfaces_at_once():
    """On both x = -z^2/10 = y, and 1 - z - z^3 - 0.15 z^2 = 0."""
    findings = search(CROSSED, [-2] * 3, [2] * 3, ["p_on_q_on"])
    (root,) = (r.real for r in np.roots([1, 0.15, 1, -1]) if abs(r.imag) < 1e-12)
    (one,) = findings.equilibria
    assert not findings.undecided
    assert np.allclose(one.at.states, [-(root**2) / 10, -(root**2) / 10, root], rtol=1e-13)


def test_delayed_values_are_present_ones_and_powers_end_at_zero():
    findings = search(DELAYED, [0], [3])
    assert np.allclose(admissible(findings), [[0], [1]], atol=1e-14)
    assert all(one.error < 1e-14 for one in findings.equilibria)


def test_modes_with_the_same_field_each_have_its_equilibria():
    findings = search(SHARED, [-2, -2], [2, 2])
    assert len(findings.equilibria) == 6
    assert np.allclose(admissible(findings), [[-1, 0], [0, 0], [1, 0]], atol=1e-14)


def test_a_field_that_modes_share_is_searched_once(monkeypatch):
    from pddecont.equilibrium import search as module

    whole, calls = module.find_zeros, []
    monkeypatch.setattr(module, "find_zeros", lambda *args: calls.append(1) or whole(*args))
    search(SHARED, [-2, -2], [2, 2])
    assert len(calls) == 1


def test_a_fold_is_undecided_in_each_mode():
    model = {**DELAYED, "parameters": {"a": 0.25, "tau": 1.0}, "modes": {"m": {"x'": "x - x(t - tau)**2 - a"}}}
    findings = search(model, [-2], [3])
    assert not findings.equilibria
    (place,) = findings.undecided
    assert place.mode == "m"
    assert place.low[0] <= 0.5 <= place.high[0] < place.low[0] + 1e-5


def test_integrals_are_searched_in_closed_form():
    """x (1 - x) of rates of the past and lags that vary, and y = int_0^1 y^2 e^(-q s) ds: zero or q / (1 - e^(-q))."""
    model = {
        "name": "kernel",
        "states": ["x", "y"],
        "parameters": {"q": 0.5, "h": 1.0},
        "modes": {
            "m": {
                "x'": "x(t - 1 - y)*(1 - x) + 0.3*x'(t - h - x**2)",
                "y'": "-y + integral(exp(-q*s)*y(t - s)**2, s, 0, h)",
            }
        },
        "initial": {"x": 0.1},
    }
    other = 0.5 / (1 - np.exp(-0.5))
    found = admissible(search(model, [-2, -0.5], [2, 3]))
    assert np.allclose(found, [[0, 0], [0, other], [1, 0], [1, other]], atol=1e-13)


def test_where_an_integral_has_no_closed_form_no_proof_is_claimed():
    model = {
        "name": "kernel",
        "states": ["x"],
        "parameters": {"h": 1.0},
        "modes": {"m": {"x'": "0.1 - integral(exp(-s**2)*tanh(x(t - s)*s), s, 0, h)"}},
        "initial": {"x": 0.1},
    }
    with pytest.raises(ConvergenceError, match="closed forms"):
        search(model, [-2], [2])


@pytest.mark.parametrize("n", [2, 4])
def test_neurons_in_a_ring_rest_in_as_many_ways_as_all_of_them_together(n):
    """x_i' = -x_i + 2 tanh x_i + a tanh x_(i+1): three each without the coupling, which is too weak to change that."""
    names = [f"x{i}" for i in range(n)]
    rates = {f"x{i}'": f"-x{i} + 2*tanh(x{i}) + a*tanh(x{(i + 1) % n}(t - tau))" for i in range(n)}
    model = {"name": "ring", "states": names, "parameters": {"a": 0.02, "tau": 1.0}, "modes": {"m": rates}}
    found = admissible(search({**model, "initial": dict.fromkeys(names, 0.1)}, [-4] * n, [4] * n))
    assert len(np.unique(np.round(found / 2), axis=0)) == len(found) == 3**n
