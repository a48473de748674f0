"""A kind of special point that says nothing of itself."""

import numpy as np

from pddecont.bifurcation import SpecialPointKind
from pddecont.bifurcation.kinds import CROSSINGS
from pddecont.stability import Multipliers


def test_a_kind_that_says_nothing_is_found_nowhere_and_not_followed():
    kind = SpecialPointKind("XX", "a new one")
    assert not (kind.on_branches or kind.on_curves or kind.needs_multipliers)
    assert kind.branch_tests(None, None) == kind.curve_tests(None, None) == ()
    assert kind.define is kind.switch is kind.go_on is None
    assert kind.good_side(None) is None
    assert kind.crossings == CROSSINGS


def test_its_multipliers_are_all_its_own():
    values = np.array([2.0, 1.0, -1.0], dtype=complex)
    kept = SpecialPointKind("XX", "a new one").remove_critical(Multipliers(np.append(values, 1.0), values))
    assert np.array_equal(kept, values)
