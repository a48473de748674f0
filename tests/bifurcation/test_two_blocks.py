"""Two blocks that stick to one belt, each alone and both at once: every special point against a simulation apart."""

import re

import numpy as np
import pytest

from tests.bifurcation.runs import follow
from tests.bifurcation.two_blocks import Blocks
from tests.runs import labels, parameter, run

BLOCKS = {
    "name": "blocks",
    "states": ["x", "v", "y", "w"],
    "parameters": {"om": 0.5, "vb": 0.3, "G": 0},
    "forcing": {"period": "2*pi/om"},
    "switches": {"one": "v - vb", "two": "w - vb"},
    "equations": {
        "x'": "v",
        "v'": "cos(om*t) + G*cos(5*om*t) - x - 0.2*v - 0.3*(x - y) - 0.4*sign(v - vb)",
        "y'": "w",
        "w'": "0.8*cos(om*t + 1) - y - 0.2*w - 0.3*(y - x) - 0.6*sign(w - vb)",
    },
    "run": {
        "mesh": {"degree": 9, "tol": 1e-10},
        "monitors": {"both": "time_in(one_on_two_on)"},
        "steps": [
            {"name": "s", "simulate": {"t_end": "40*2*pi/om"}},
            {"name": "o", "orbit": {"from": "s"}},
            follow("vb", "o", {"vb": [0.15, 0.65]}),
            follow("G", "o", {"G": [-0.6, 0.6]}),
        ],
    },
}
# So far beside a point the motion is as the branch says on that side; so many periods from rest it has settled to that.
BESIDE, N_PERIODS = 1e-8, 45


@pytest.fixture(scope="module")
def branches(tmp_path_factory):
    return run(BLOCKS, tmp_path_factory.mktemp("b") / "a.h5")


def list_events(step, row):
    """Return the events of a recorded orbit as (block, kind, whether it sticks), in order."""
    found = []
    for name in step.orbit(row)["signature"].tobytes().decode().split():
        event = re.search(r"(one|two)_(off_up|off_down|up|down)(?:>(.*))?$", name)
        found += [(event[1], event[2], f"{event[1]}_on" in (event[3] or ""))] if event else []
    return found


def turn(events):
    """Return a cycle of events from the one on that makes it the first of its turns in the order of the alphabet."""
    return min((tuple(events[k:] + events[:k]) for k in range(len(events))), default=())


@pytest.mark.parametrize("name", ["vb", pytest.param("G", marks=pytest.mark.slow)])
def test_beside_each_point_the_motion_is_what_the_branch_says(branches, name):
    step = branches.step(name)
    rows = list(step.order)
    special = [k for k, i in enumerate(rows) if step.labels[i] and not step.labels[i].startswith("EP")]
    for k in special:
        at = float(parameter(step, name)[k])
        for side, row in ((-1, rows[k - 1]), (1, rows[k + 1])):
            given = {"om": 0.5, "vb": 0.3, "G": 0.0} | {name: at + side * BESIDE}
            expected = turn(list_events(step, row))
            assert turn(Blocks(**given).follow(N_PERIODS)) == expected, (step.labels[rows[k]], at, side)
    assert np.all(step.points["verified"] == 1)


def test_all_kinds_of_points_are_there_and_both_blocks_stick_at_once(branches):
    kinds = {label.rstrip("0123456789") for name in ("vb", "G") for label in labels(branches.step(name))}
    assert kinds >= {"CS", "GS", "SS", "AS"}
    for name in ("vb", "G"):
        assert np.max(branches.step(name).points["monitors"][:, 0]) > 0.5
