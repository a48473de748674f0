"""Kinds of special points by their labels, and new ones made known."""

import pytest

from pddecont.bifurcation import SpecialPointKind, find_kind, forget_kind, list_kinds, register_kind
from pddecont.bifurcation.builtin import BUILTIN

NEW = SpecialPointKind("XX", "a new one")


@pytest.fixture
def registered():
    register_kind(NEW)
    yield NEW
    forget_kind("XX")


def test_new_kinds_come_after_the_programs_own(registered):
    assert list_kinds() == [*BUILTIN, registered]
    assert find_kind("XX") is registered
    assert find_kind("GR") is next(kind for kind in BUILTIN if kind.label == "GR")


def test_a_forgotten_kind_is_unknown():
    register_kind(NEW)
    forget_kind("XX")
    assert find_kind("XX") is None and find_kind("") is None
    assert list_kinds() == list(BUILTIN)
    with pytest.raises(KeyError):
        forget_kind("XX")


@pytest.mark.parametrize("label", ["GR", "XX"])
def test_a_label_is_given_once(registered, label):
    with pytest.raises(ValueError, match=f"there is a kind of special point '{label}' already"):
        register_kind(SpecialPointKind(label, "another"))
    assert len(list_kinds()) == len(BUILTIN) + 1


def test_the_programs_own_kinds_cannot_be_forgotten():
    with pytest.raises(KeyError):
        forget_kind("GR")
    assert find_kind("GR") is not None
