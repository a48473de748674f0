"""Conditions under which surfaces repel, made of equations: where they are asked, and what they say."""

import pytest
import sympy

from pddecont.model import TIME, list_surfaces_met, write_repulsion
from tests.conftest import model_from
from tests.model.equations_models import numbers_at


def model(law, other="1", **more):
    given = {"name": "m", "states": ["x", "y"], "equations": {"x'": law, "y'": other}, "initial": {"x": 9, "y": 9}}
    return model_from({**given, **more})


def find_rules(m):
    """Return the conditions of the segments that have one, by name."""
    rules = zip(m.segments.values(), [write_repulsion(m, s) for s in m.segments.values()], strict=True)
    return {segment.name: rule for segment, rule in rules if rule != sympy.false}


def test_a_motion_that_arrives_is_not_asked():
    assert find_rules(model("y - sign(x)")) == {}


def test_a_law_that_does_not_jump_is_not_asked():
    assert find_rules(model("y - max(x, 0)", jumps={"j": {"at": "y - 3", "reset": {"x": 0}}})) == {}


def test_after_a_jump_the_rates_on_both_sides_are_asked():
    m = model("y + sign(x)", jumps={"j": {"at": "y - 3", "reset": {"x": 0}}})
    rules = find_rules(m)
    assert set(rules) == {s.name for s in m.segments.values() if s.event == "j" and s.to != "x_on"}
    x, y = m.state_symbols
    for value, holds in ((-2.0, False), (0.0, True), (2.0, False)):
        assert {bool(rule.subs({x: 0.0, y: value, TIME: 0.0})) for rule in rules.values()} == {holds}
        assert not any(rule.subs({x: 1e-3, y: value, TIME: 0.0}) for rule in rules.values())


def test_a_side_on_which_nothing_holds_the_motion_elsewhere_is_not_asked():
    """Above x = 0.4 cos t no law holds a motion on x = 0.2: it has no field along it there."""
    jumps = {"j": {"at": "y - 3", "reset": {"y": 0, "x": "0.4*cos(t)"}}}
    m = model("1 - where(x > 0.2 or x > 0.4*cos(t), 2, 0)", forcing={"period": "2*pi"}, jumps=jumps)
    assert "x_on_x2_below" in m.modes and "x_on_x2_above" not in m.modes
    rules = [write_repulsion(m, s) for s in m.segments.values()]
    assert not any(rule.has(sympy.nan, sympy.zoo) for rule in rules)
    leads_on = [rule for s, rule in zip(m.segments.values(), rules, strict=True) if s.to == "x_on_x2_below" and s.anew]
    assert leads_on and set(leads_on) == {sympy.false}


@pytest.mark.parametrize(("y", "repels"), [(0.3, True), (-0.3, True), (1.2, False), (-1.2, False), (1.0, False)])
def test_a_surface_is_described_with_its_rates(y, repels):
    m = model("y + sign(x)")
    (surface,) = list_surfaces_met(m.derived.surfaces, m.derived.find_digits("x_above"), numbers_at(m, x=0.0, y=y))
    assert (surface.below, surface.above, surface.repels) == (pytest.approx(y - 1), pytest.approx(y + 1), repels)
    said = surface.describe({"x": 0.0, "y": y})
    assert f"its rate is {y - 1:.6g} below and {y + 1:.6g} above" in said
    assert f"both fields {'point' if repels else 'begin to point'} away" in said
