"""The program's own kinds of special points fit together."""

import pytest

from pddecont.bifurcation.builtin import BUILTIN, COUNTED
from pddecont.results import CONTINUE
from pddecont.tables.words import OLD_KIND_NAMES
from tests.conftest import ROOT

BY_LABEL = {kind.label: kind for kind in BUILTIN}
# Kinds that files of format 2 do not have.
LATER = {"MC", "GD", "CS", "GS", "SS", "AS", "HB", "HH"}


def test_labels_and_names_are_given_once():
    assert len(BY_LABEL) == len({kind.name for kind in BUILTIN}) == len(BUILTIN)
    assert {label: kind.name for label, kind in BY_LABEL.items() if label not in LATER} == OLD_KIND_NAMES


@pytest.mark.parametrize("kind", BUILTIN, ids=lambda kind: kind.label)
def test_a_kind_is_found_somewhere_and_its_label_fits_into_files(kind):
    assert kind.on_branches or kind.on_curves
    assert len(kind.label.encode()) <= int(CONTINUE.points["kind"].dtype[1:])
    assert f"`{kind.label}`" in (ROOT / "docs" / "bifurcations.md").read_text()


@pytest.mark.parametrize("kind", [k for k in BUILTIN if k.define], ids=lambda kind: kind.label)
def test_points_on_a_curve_are_kinds_that_curves_have(kind):
    """A kind that is followed is found along branches, and what is counted on its curve is seen from multipliers."""
    assert kind.on_branches
    for label in kind.crossings:
        assert BY_LABEL[label].on_curves
        assert BY_LABEL[label] in COUNTED or label in ("R1", "R2", "TT")


def test_counted_points_are_no_test_functions_zeros():
    assert all(kind.on_curves and kind.needs_multipliers and not kind.on_branches for kind in COUNTED)
    assert all(kind.curve_tests(None, None) == () for kind in COUNTED)
