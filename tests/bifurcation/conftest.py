"""Expensive branches that tests of several kinds of special points look at."""

import pytest

from tests.bifurcation import runs
from tests.bifurcation.runs import FREE, chain, follow, settle
from tests.orbits import settle_to_orbit
from tests.runs import run


@pytest.fixture(scope="session")
def ball(tmp_path_factory):
    """The bouncing ball in G, its doubled orbits, and its doublings and folds in two parameters."""
    steps = [
        *settle("200*2*pi"),
        follow("c", "o", {"G": [0.3, 1.2]}, stability=True),
        follow("twice", ("c", "PD1"), {"G": [0.3, 1.3]}, branch="switch", stability=True),
        follow("pd", ("c", "PD1"), {"G": [0.3, 2], "r": [0.1, 0.95]}, stability=True),
        follow("lp", ("c", "LP1"), {"G": [0.05, 2], "r": [0.1, 0.95]}, stability=True),
    ]
    return run(runs.ball(steps), tmp_path_factory.mktemp("ball") / "a.h5")


@pytest.fixture(scope="session")
def fig4_7(tmp_path_factory):
    """The impact oscillator in the gain, from impacts to none: by itself, stopped at its grazing, and by hand."""
    gain = {"K": [0.1, 0.3]}
    steps = [
        *settle("60*2*pi/omega"),
        follow("c", "o", gain, step={"max": 0.05}, stability=True, direction="up"),
        follow("stop", "o", gain, step={"max": 0.05}, direction="up", signature_change="stop"),
        follow("by_hand", ("stop", "GR1"), gain, signature=["NC", "C", "NC", "C"]),
    ]
    monitors = {"contact_time": "time_in(C)", "x_max": "max(x)"}
    return run(chain(0.12, steps, monitors=monitors), tmp_path_factory.mktemp("fig4_7") / "a.h5")


@pytest.fixture(scope="session")
def fig4_8(tmp_path_factory):
    """The grazings of the delay equation's impacting orbit, and of its free one, in delay and gain."""
    steps = [
        *settle("60*2*pi/omega"),
        follow("c", "o", {"K": [0.1, 0.3]}, step={"max": 0.05}, direction="up", stability=True),
        follow("gr", ("c", "GR1"), {"tau_d": [3.0, 4.6], "K": [0.05, 0.6]}, stability=True),
        follow("one", ("c", "VS1"), {"tau_d": [2, 7.4], "K": [0.05, 0.6]}, stability=True),
    ]
    text = {
        "model": "impact_oscillator",
        "mesh": {"degree": 10, "tol": 1e-11},
        "monitors": {"x_max": "max(x)"},
        "steps": steps,
    }
    return run(text, tmp_path_factory.mktemp("fig4_8") / "a.h5")


MESH = {"degree": 8, "tol": 1e-9}


@pytest.fixture(scope="session")
def free_orbit():
    """The orbit of a driven oscillator that watches no event, at omega = 2 and c = 0.1."""
    model = {**FREE, "parameters": {**FREE["parameters"], "omega": 2.0}}
    return settle_to_orbit(model, t_end=300, mesh=MESH)


@pytest.fixture(scope="session")
def far_orbit():
    """The same oscillator with a hard wall at 0.5, out of its reach."""
    return settle_to_orbit("wall_oscillator", {"wall": 0.5}, 300, mesh=MESH)


@pytest.fixture(scope="session")
def hop_orbit():
    """The same oscillator that hits the wall at 0.2 once a period."""
    return settle_to_orbit("wall_oscillator", t_end=300, mesh=MESH)


@pytest.fixture(scope="session")
def soft_orbit():
    """The impact oscillator's orbit, with one contact in two periods."""
    return settle_to_orbit("impact_oscillator", t_end="60*2*pi/omega", mesh=MESH)


@pytest.fixture(scope="session")
def ball_orbit():
    """The bouncing ball's orbit, at G = 0.6 and r = 0.8."""
    return settle_to_orbit("bouncing_ball", t_end="200*2*pi", mesh=MESH)
