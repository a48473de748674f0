"""Branches of orbits begin at the Hopf points that they were asked to start from."""

import json
from dataclasses import replace

import numpy as np
import pytest

from pddecont.plot.births import find_birth
from pddecont.plot.branch_lines import draw_birth
from pddecont.plot.columns import read_column
from pddecont.plot.heights import read_heights
from tests.plot.drawn import lines

HOPF = {"branch": "switch", "from": {"file": None, "step": "resting", "point": "HB1"}}


@pytest.fixture
def ask(resting):
    """Return a function that gives the orbits as if a step had asked for them so."""
    step = resting.step("cycles")
    return lambda asked: replace(step, meta={**step.meta, "settings": json.dumps({"step": {"continue": asked}})})


def test_the_hopf_point_is_found_among_the_steps_drawn(resting, ask):
    source = resting.step("resting")
    step, row = find_birth(ask(HOPF), [source])
    assert step is source
    assert source.labels[row] == "HB1"
    assert find_birth(ask(HOPF), [resting.step("cycles")]) is None


@pytest.mark.parametrize(
    "asked",
    [
        None,
        [],
        {**HOPF, "branch": "same"},
        {**HOPF, "from": "resting"},
        {**HOPF, "from": {**HOPF["from"], "file": "other.h5"}},
        {**HOPF, "from": {**HOPF["from"], "point": "HB9"}},
        {**HOPF, "from": {**HOPF["from"], "point": "BE1"}},
    ],
)
def test_other_branches_are_born_nowhere(resting, ask, asked):
    assert find_birth(ask(asked), [resting.step("resting")]) is None


def test_the_first_orbits_are_joined_as_orbits_grow(resting, axes):
    """The way of a height from the point is that of the amplitude, the parameter's its square."""
    step = resting.step("cycles")
    xs, heights = read_column(step, "K") + 0.1, read_heights(step, "x") + np.array([[0.2], [-0.2]])
    draw_birth(axes, step, (0.3, 0.3), xs, heights, lambda step, family: "red", 1.0)
    drawn = lines(axes, "-")
    assert len(drawn) == 2
    for line, height in zip(drawn, heights[:, 0], strict=True):
        assert line[0] == pytest.approx([0.3, 0.3])
        assert line[-1] == pytest.approx([xs[0], height])
        grown = (line[:, 1] - 0.3) / (height - 0.3)
        assert line[:, 0] - 0.3 == pytest.approx((xs[0] - 0.3) * grown**2)


def test_a_diagram_joins_them(resting, show, ask):
    born = replace(resting, steps={**resting.steps, "cycles": ask(HOPF)})
    apart = show(resting, "diagram", ("resting", "cycles")).axes[0]
    joined = show(born, "diagram", ("resting", "cycles")).axes[0]
    assert len(joined.lines) == len(apart.lines) + 2
    assert len(show(born, "diagram", ("resting", "cycles"), y="top").axes[0].lines) == len(
        show(resting, "diagram", ("resting", "cycles"), y="top").axes[0].lines
    )
