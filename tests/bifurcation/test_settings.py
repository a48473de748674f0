"""What branches are followed with."""

import numpy as np

from pddecont.bifurcation import BranchSettings
from pddecont.collocation import MeshRule
from pddecont.stability import MultiplierCache

RULE = MeshRule(8, tol=1e-9)


def test_all_kinds_are_wanted_unless_some_are_named():
    free, ranges = ("omega", "c"), ((1.7, 2.7), (0.1, 0.5))
    settings = BranchSettings(free, ranges, RULE)
    assert settings.wants("GR") and settings.wants("any other")
    some = BranchSettings(free, ranges, RULE, detect=("LP",))
    assert some.wants("LP") and not some.wants("GR")
    assert not BranchSettings(free, ranges, RULE, detect=()).wants("LP")
    assert np.allclose(settings.widths, (1.0, 0.4), rtol=1e-15)


def test_multipliers_are_found_even_where_none_were_asked_for():
    cache = MultiplierCache(3)
    assert BranchSettings((), (), RULE, cache).find_multipliers() is cache
    assert isinstance(BranchSettings((), (), RULE).find_multipliers(), MultiplierCache)


def test_the_system_has_the_free_parameters_in_units_of_their_ranges(free_orbit):
    settings = BranchSettings(("c", "omega"), ((0.1, 0.5), (1.7, 2.7)), RULE)
    system, orbit = settings.make_system(free_orbit)
    assert orbit.problem.free == system.problem.free == ("c", "omega")
    assert orbit.free.tolist() == [0.1, 2.0]
    assert np.allclose(system.scaling.scale[orbit.problem.unknowns.free], (0.4, 1.0), rtol=1e-15)
    assert system.scaling.scale[orbit.problem.unknowns.durations] == orbit.period
    assert np.max(np.abs(system.at(orbit.x).residual)) < 1e-9
    assert system.rule is RULE
