"""The side of a surface on which a motion is: from the search, or from the value where a step is cut."""

import pytest

from tests.simulate.motions import COUNTER


@pytest.fixture
def run(interpreted):
    run = interpreted.start(COUNTER.replace("H}", "c - 1}").replace("DIR", "any"), [0.0, 0.0])
    run.sides = interpreted.event_sides
    return run


@pytest.mark.parametrize(("c", "side"), [(0.5, -1), (1.5, 1), (1.0, 0), (1.0 + 1e-15, 0), (1.0 + 1e-9, 1)])
def test_an_arc_begins_on_a_side_or_on_the_surface(run, c, side):
    run.core.y[0] = c
    run.core.side[0] = 7
    run.sides.note_sides(run.core, 0.0)
    assert run.core.side[0] == side
    assert run.core.count[8] == 0  # the arc is not fresh any more


def test_a_whole_step_keeps_what_the_search_found(run):
    run.core.y[0], run.core.found_side[0] = 0.5, 1
    run.sides.update_side(run.core, 0, 0, 0.0, True)
    assert run.core.side[0] == 1


@pytest.mark.parametrize(("c", "side"), [(0.5, -1), (1.5, 1), (1.0, -1)])
def test_a_cut_step_keeps_the_sign_there_and_none_where_it_is_zero(run, c, side):
    run.core.y[0], run.core.found_side[0], run.core.side[0] = c, 7, -1
    run.sides.update_side(run.core, 0, 0, 0.0, False)
    assert run.core.side[0] == side
