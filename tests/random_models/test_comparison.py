"""The comparison tells what is wrong with an orbit: tried on orbits that are right, moved, slide or miss events."""

from dataclasses import replace

import numpy as np
import pytest

from tests.random_models.comparison import check_multiplier, check_period
from tests.random_models.formula import States, name
from tests.random_models.random_model import RandomModel, Segment
from tests.random_models.recorded import RecordedOrbit

X = States(("x", "y"))


def tooth(events=None, segments=None, resets=None, delays=("tau",)):
    """Return x' = 1 from d to 1, y' = -y + x(t - tau), and what else is given."""
    return RandomModel(
        seed=0,
        family="tooth",
        states=("x", "y"),
        parameters={"d": 0.2, "tau": 0.3},
        delays=delays,
        modes={"go": {"x": name("d") * 0 + 1, "y": 0 - X["y"] + X["x", "tau"]}},
        initial={"mode": "go", "x": 0.0, "y": 0.0},
        free="d",
        span=(0.1, 0.3),
        events={"top": X["x"] - 1, **(events or {})},
        resets={"back": {"x": name("d")}, **(resets or {})},
        segments={"rise": Segment("go", "top", "rising", "back", "go"), **(segments or {})},
    )


def exact_orbit():
    """Return the periodic orbit of :func:`tooth`, which starts at x = d: y is a line and an exponential in two parts.

    x(t - tau) = x(t) - tau + (0.8 where the delay reaches over the jump, t < tau).
    """
    d, tau, period = 0.2, 0.3, 0.8
    rise = np.exp(-period)
    # y = x(t) - tau - 1 + 0.8 (t < tau) + c exp(-t), and continuous at tau.
    early, late = d - tau - 1 + 0.8, 1 - tau - 1
    c_early = (late - early + 0.8 * np.exp(tau) * rise) / (1 - rise)
    c_late = c_early + 0.8 * np.exp(tau)
    nodes = [np.linspace(0, tau, 13), np.linspace(tau, period, 17)]
    y = [d + nodes[0] - tau - 0.2 + c_early * np.exp(-nodes[0]), d + nodes[1] - tau - 1 + c_late * np.exp(-nodes[1])]
    values = [np.stack([d + t, v], axis=1) for t, v in zip(nodes, y, strict=True)]
    orbit = RecordedOrbit(
        0.0, period, ["rise"], np.array([period]), [0.0, tau], nodes, values, 1e-12, {"d": d, "tau": tau}
    )
    orbit.weights.update({i: weights(n) for i, n in enumerate(nodes)})
    return orbit


def weights(nodes):
    gaps = (nodes[:, None] - nodes[None, :]) / (nodes[-1] - nodes[0]) + np.eye(len(nodes))
    return 1 / np.prod(gaps, axis=1)


def test_an_exact_orbit_comes_back():
    verdict = check_period(tooth(), exact_orbit())
    assert verdict.fault == ""
    assert verdict.deviation < 1e-9


def test_an_orbit_that_is_moved_deviates():
    orbit = exact_orbit()
    moved = replace(orbit, values=[v + np.array([0.0, 1e-4]) for v in orbit.values])
    verdict = check_period(tooth(), moved)
    assert verdict.fault == "deviates"
    assert verdict.deviation > 5 * verdict.allowed


def test_a_jump_of_a_delayed_value_that_is_not_listed_is_found():
    model = tooth(
        {"echo": X["x", "tau"] - 0.5},
        {"hit": Segment("go", "echo", "falling", "push", "go")},
        {"push": {"y": X["y"] + 1}},
    )
    assert check_period(model, exact_orbit()).fault == "'hit' happens at t = 0.3 instead of 'rise'"


def test_a_delayed_event_that_is_not_listed_is_found():
    model = tooth(
        {"kick": ("top", "tau")}, {"hit": Segment("go", "kick", "any", "push", "go")}, {"push": {"y": X["y"] + 1}}
    )
    assert check_period(model, exact_orbit()).fault == "'hit' happens at t = 0.3 instead of 'rise'"


def test_a_multiplier_is_measured():
    """A change of y shrinks by exp(-0.8) a period; x forgets its own at once, and its event fixes the phase."""
    _, measured, agrees = check_multiplier(tooth(), exact_orbit(), [np.exp(-0.8)])
    assert measured == pytest.approx(np.exp(-0.8), abs=1e-5)
    assert agrees
    assert not check_multiplier(tooth(), exact_orbit(), [0.5])[2]
