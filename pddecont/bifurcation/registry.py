"""The registry of special points: the program's own kinds, and those that others make known."""

from __future__ import annotations

from pddecont.bifurcation.builtin import BUILTIN
from pddecont.bifurcation.kinds import SpecialPointKind

_REGISTERED: dict[str, SpecialPointKind] = {}


def register_kind(kind: SpecialPointKind) -> None:
    """Make a kind known, after those that are known already.

    Raises
    ------
    ValueError
        If another kind has its label.
    """
    if find_kind(kind.label) is not None:
        raise ValueError(f"there is a kind of special point '{kind.label}' already")
    _REGISTERED[kind.label] = kind


def forget_kind(label: str) -> None:
    """Forget a kind that :func:`register_kind` made known."""
    del _REGISTERED[label]


def has_registered_kinds() -> bool:
    """Return whether others made kinds known in this process."""
    return bool(_REGISTERED)


def list_kinds() -> list[SpecialPointKind]:
    """Return all kinds: the program's own, then those that were registered."""
    return [*BUILTIN, *_REGISTERED.values()]


def find_kind(label: str) -> SpecialPointKind | None:
    """Return the kind of a label; None if there is none."""
    return next((kind for kind in list_kinds() if kind.label == label), None)
