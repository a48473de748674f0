"""Branches that are loops."""

import math

import numpy as np
import pytest

from pddecont.tables import describe_endings
from tests.bifurcation.runs import follow, settle
from tests.runs import monitor, parameter, run

GROWTH = "(0.25 - (x**2 + y**2 - 1)**2 - m**2 - k**2)"
TURN = "(1 + 0.3*m + 0.5*(x**2 + y**2) + 0.2*x)"
# Orbits with (r^2 - 1)^2 + m^2 + k^2 = 1/4, whose phase drifts from point to point.
ISLAND = {
    "name": "island",
    "states": ["x", "y"],
    "parameters": {"m": 0.1, "k": 0.0},
    "modes": {"m": {"x'": f"{GROWTH}*x - {TURN}*y", "y'": f"{TURN}*x + {GROWTH}*y"}},
    "initial": {"x": 1, "y": 0},
}
# The same orbits begun by an event that does nothing.
SECTION = {
    **ISLAND,
    "events": {"top": "y"},
    "segments": {"turn": {"mode": "m", "event": "top", "direction": "rising", "to": "m"}},
    "initial": {"mode": "m", "x": 1, "y": 0.1},
}
CLOSED = "the branch is closed: it is back at its first point"


def follow_island(path, model, *more, **options):
    """Return the results of the branch of orbits in m."""
    block = {
        "monitors": {"amp": "amplitude(x)"},
        "steps": [*settle(100), follow("c", "o", {"m": [-1, 1]}, **options), *more],
    }
    return run({**model, "run": block}, path / "a.h5")


@pytest.mark.parametrize("model", [ISLAND, SECTION], ids=["smooth", "with an event"])
@pytest.mark.parametrize("direction", ["both", "down", "up"])
def test_an_island_is_gone_round_once(tmp_path, model, direction):
    step = follow_island(tmp_path, model, direction=direction).step("c")
    m, squared = parameter(step, "m"), monitor(step, "amp") ** 2
    assert np.max(np.abs((squared - 1) ** 2 + m**2 - 0.25)) < 1e-7
    angle = np.unwrap(np.arctan2(squared - 1, m))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2 * math.pi, abs=1e-6)
    assert sorted(label for label in step.labels if label) == ["EP1", "LP1", "LP2"]
    assert sorted(parameter(step, "m", label) for label in ("LP1", "LP2")) == pytest.approx([-0.5, 0.5], abs=1e-9)
    texts = describe_endings(step)
    assert [text.partition(": ")[2] for text in texts] == [CLOSED] * (2 if direction == "both" else 1)


def test_a_closed_curve_of_folds_is_gone_round_once(tmp_path):
    curve = follow("lp", ("c", "LP1"), {"m": [-1, 1], "k": [-1, 1]}, step={"max": 0.3}, detect=[])
    step = follow_island(tmp_path, ISLAND, curve, direction="up").step("lp")
    m, k = parameter(step, "m"), parameter(step, "k")
    assert np.max(np.abs(np.hypot(m, k) - 0.5)) < 1e-8
    angle = np.unwrap(np.arctan2(k, m))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2 * math.pi, abs=1e-5)
    assert all(text.endswith(CLOSED) for text in describe_endings(step))
