"""What is evaluated along branches of orbits and along curves of special points."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.bifurcation import BranchSettings, extend_system, make_tests
from pddecont.bifurcation.grazing import define_grazing
from pddecont.bifurcation.period_doubling import guess_doubled_orbit
from pddecont.bifurcation.user_function import UserFunction
from pddecont.collocation import MeshRule
from pddecont.continuation import CurvePoint
from pddecont.orbit import Orbit, PeriodicOrbitSystem, measure_orbit, parse_monitor
from pddecont.stability import MultiplierCache

RULE = MeshRule(8, tol=1e-9)


def first_parameter(orbit):
    return next(iter(orbit.numeric.model.parameters))


def evaluated_along(orbit, detect=None, *, multipliers=False, levels=()):
    """Return what is evaluated along the branch of an orbit in its first parameter."""
    cache = MultiplierCache() if multipliers else None
    monitors = tuple(parse_monitor(orbit.numeric, name, text) for name, text in levels)
    settings = BranchSettings((first_parameter(orbit),), ((0.0, 3.0),), RULE, cache, monitors, detect)
    system, orbit = settings.make_system(orbit)
    return make_tests(system.at(orbit.x), settings)


def labels_of(functions):
    return sorted({test.kind for test in functions.tests})


def test_each_wanted_kind_brings_its_test_functions(hop_orbit):
    assert labels_of(evaluated_along(hop_orbit)) == ["GR", "VS"]
    assert labels_of(evaluated_along(hop_orbit, levels=[("top", "max(x)")])) == ["GR", "UF", "VS"]
    assert labels_of(evaluated_along(hop_orbit, ("GR",))) == ["GR"]
    assert labels_of(evaluated_along(hop_orbit, ())) == []


def test_doubled_orbits_are_tested_for_their_fall(soft_orbit):
    """An orbit of two segments over two periods cannot fall onto one; the same taken twice, a little apart, can."""
    assert "PD" not in labels_of(evaluated_along(soft_orbit))
    twice, direction = guess_doubled_orbit(soft_orbit, RULE)
    apart = Orbit(twice.problem, twice.x + 0.01 * direction / np.max(np.abs(direction)))
    assert "PD" in labels_of(evaluated_along(apart))


@pytest.mark.parametrize(("detect", "watched"), [(None, True), (("GR",), True), (("VS",), True), (("LP",), False)])
def test_orbits_that_are_none_matter_where_signatures_do(far_orbit, detect, watched):
    """The free orbit through a wall at 0.5 - 0.3: it is crossed, and not listed."""
    index = far_orbit.numeric.parameter_index("wall")
    p = far_orbit.problem.parameters.copy()
    p[index] = 0.2
    through = Orbit(replace(far_orbit.problem, parameters=p), far_orbit.x)
    functions = evaluated_along(through, detect)
    system = PeriodicOrbitSystem(through.problem, measure_orbit(through))
    violation = functions.find_violation(CurvePoint(system, system.at(through.x)))
    assert violation.code == ("also_crossed" if watched else "")


def test_multipliers_are_counted_where_they_are_known(hop_orbit):
    plain, whole = evaluated_along(hop_orbit), evaluated_along(hop_orbit, multipliers=True)
    assert plain.counts.count(point_in(hop_orbit)) == (1,)
    assert whole.counts.count(point_in(hop_orbit)) == (0, 0, 0, 1)
    assert evaluated_along(hop_orbit, ()).counts is None


def point_in(orbit):
    """Return a point of the branch on which the parameter grows."""
    orbit = orbit.with_free((first_parameter(orbit),))
    system = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, (3.0,)))
    return CurvePoint(system, system.at(orbit.x), None, np.ones(len(orbit.x)))


def test_a_curve_has_its_own_tests(far_orbit):
    """Along a curve of a user function other functions and no grazings are tested; along one of grazings second."""
    monitors = tuple(parse_monitor(far_orbit.numeric, name, "max(x)") for name in ("own", "other"))
    settings = BranchSettings(("omega", "wall"), ((1, 3), (0, 1)), RULE, MultiplierCache(), monitors)
    inner, orbit = settings.make_system(far_orbit)
    along = {
        "user": extend_system(inner, UserFunction(monitors[0])),
        "grazing": extend_system(inner, define_grazing(orbit)),
    }
    found = {name: make_tests(system.at(orbit.x), settings) for name, system in along.items()}
    assert [test.reason.values.get("name", test.kind) for test in found["user"].tests] == ["other"]
    assert labels_of(found["grazing"]) == ["GG", "UF"]
    point = CurvePoint(along["grazing"], along["grazing"].at(orbit.x))
    assert found["grazing"].counts.count(point) == (0, 0, 0)
    assert not found["grazing"].find_violation(point)
