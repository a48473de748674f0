"""Branches where they return to the section of a sweep."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pddecont.plot.branch_returns import draw_branch_returns, find_returns, join_returns
from pddecont.plot.style import find_marker


def test_branches_lie_under_the_dots_they_explain(simulated, axes):
    step, branch = simulated.steps["diagram"], simulated.steps["branch"]
    draw_branch_returns(axes, [branch], step, "beta", "x")
    lines = [line.get_xydata() for line in axes.lines]
    assert lines
    one = [i for i in range(len(step)) if step.points["n_segments"][i, 0] == 1]
    for i in one:
        beta = step.points["parameters"][i, 4]
        for x in step.orbit(i)["returns"][:, 0]:
            gap = min(np.min(np.abs(line[:, 1] - x)[np.abs(line[:, 0] - beta) < 2.0], initial=np.inf) for line in lines)
            assert gap < 0.03


def test_special_points_of_branches_are_marked_at_every_return(simulated, axes):
    step, branch = simulated.steps["diagram"], simulated.steps["branch"]
    labels, handles = draw_branch_returns(axes, [branch], step, "beta", "x")
    assert [label.text for label in labels] == ["UF1"]
    (marks,) = (line.get_xydata() for line in axes.lines if line.get_marker() == find_marker("UF"))
    assert marks[:, 0] == pytest.approx([37.0, 37.0], abs=1e-9)
    assert (labels[0].x, labels[0].y) == pytest.approx(tuple(marks[0]))
    assert [h.get_label() for h in handles] == ["followed: orbits"]


def test_on_a_section_that_is_no_phase_nothing_is_known(simulated):
    step, branch = simulated.steps["diagram"], simulated.steps["branch"]
    assert len(find_returns(branch, 0, 0, step)) == 2
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(step.meta, "section", {"event": "impact"})
        assert len(find_returns(branch, 0, 0, step)) == 0


@settings(max_examples=40, deadline=None)
@given(st.lists(arrays(float, 4, elements=st.floats(-1, 1)), min_size=1, max_size=5))
def test_returns_are_turned_and_not_changed(returns):
    joined = join_returns(returns)
    assert joined.shape == (len(returns), 4)
    assert np.array_equal(joined[0], returns[0])
    for k in range(1, len(returns)):
        turns = [np.roll(returns[k], n) for n in range(4)]
        assert any(np.array_equal(joined[k], turn) for turn in turns)
        gaps = [np.max(np.abs(turn - joined[k - 1])) for turn in turns]
        assert np.max(np.abs(joined[k] - joined[k - 1])) == min(gaps)
