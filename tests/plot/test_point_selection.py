"""Points shown closely."""

import pytest

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest, point_selection
from pddecont.plot.point_selection import select_orbits, select_points


def test_points_asked_for_come_before_special_ones(every):
    gain, doubled = every.step("in_gain"), every.step("doubled")
    assert select_points([gain], ViewRequest(labels=("GR1",), indices=(3,))) == [(gain, 16), (gain, 3)]
    assert select_points([gain, doubled], ViewRequest()) == [(gain, 8), (gain, 16), (doubled, 0)]
    assert select_points([gain, doubled], ViewRequest(), 2) == [(gain, 8), (gain, 16)]
    # A label is looked for in the last step first, an index belongs to it.
    assert select_points([gain, doubled], ViewRequest(labels=("LP1",), indices=(1,))) == [(gain, 8), (doubled, 1)]


def test_without_special_points_the_ends_are_shown_or_nothing(every):
    step = every.step("in_delay")
    assert select_points([step], ViewRequest()) == [(step, 0), (step, 8)]
    assert select_points([step], ViewRequest(), ends=False) == []
    assert select_points([every.step("orbit")], ViewRequest()) == [(every.step("orbit"), 0)]


def test_orbits_that_have_shrunk_are_not_shown_by_themselves(every, monkeypatch):
    gain = every.step("in_gain")
    assert select_orbits([gain], ViewRequest()) == [(gain, 8), (gain, 16)]
    monkeypatch.setattr(point_selection, "SHRUNK", ("LP",))
    assert select_orbits([gain], ViewRequest()) == [(gain, 16)]


def test_points_that_are_not_there(every):
    with pytest.raises(ResultsError, match="12 points, no index 99"):
        select_points([every.step("doubled")], ViewRequest(indices=(99,)))
    with pytest.raises(ResultsError, match="step 'doubled' has no point 'LP7'"):
        select_points([every.step("in_gain"), every.step("doubled")], ViewRequest(labels=("LP7",)))
