"""Several files in one picture."""

from dataclasses import replace
from pathlib import Path

import pytest

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest, draw_picture
from pddecont.plot.several_files import name_files, select_steps, split_name
from tests.plot.drawn import coloured, legend, lines


def test_steps_of_both_are_drawn_and_named_with_their_file(every):
    other = replace(every, path=Path("other.h5"))
    request = ViewRequest(view="diagram", steps=("in_delay",))
    view, steps = select_steps([every, other], request)
    assert view.name == "diagram"
    assert [split_name(step) for step in steps] == [("every", "in_delay"), ("other", "in_delay")]
    alone, both = draw_picture(every, request), draw_picture([every, other], request)
    assert len(lines(both.axes[0], "-")) == 2 * len(lines(alone.axes[0], "-")) > 0
    named = legend(both)
    assert named["every"] != named["other"] and len(both.axes) == 1
    assert set(coloured(both.axes[0])) == {named["every"], named["other"]}


def test_one_file_is_as_ever(every):
    _, steps = select_steps([every], ViewRequest(steps=("in_gain",)))
    assert [step.name for step in steps] == ["in_gain"] and split_name(steps[0]) == ("", "in_gain")


def test_files_have_the_shortest_names_that_tell_them_apart():
    assert name_files([Path("a/x.h5"), Path("b/y.h5")]) == ["x", "y"]
    assert name_files([Path("a/x.h5"), Path("b/x.h5")]) == ["a/x", "b/x"]
    assert name_files([Path("x.h5"), Path("x.hdf5")]) == ["x.h5", "x.hdf5"]
    with pytest.raises(ResultsError, match="twice"):
        name_files([Path("x.h5"), Path("x.h5")])


def test_a_view_of_one_step_says_so(every):
    other = replace(every, path=Path("other.h5"))
    with pytest.raises(ResultsError, match="one file"):
        draw_picture([every, other], ViewRequest(view="multipliers", steps=("in_gain",)))
