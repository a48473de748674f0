"""Which tables each kind of step has; a kind that nobody made tables for has its points."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from pddecont.errors import ResultsError, suggest
from pddecont.results import Step
from pddecont.tables.attractors import list_attractors, list_cells, list_returns
from pddecont.tables.columns import list_columns
from pddecont.tables.equilibria import list_equilibria, list_roots, list_special_equilibria
from pddecont.tables.exploration import list_branches, list_motions, list_tori, list_unexplained
from pddecont.tables.orbits import list_multipliers, list_orbit, list_points, list_special_points
from pddecont.tables.precision import list_settings
from pddecont.tables.trajectories import list_events, list_trajectory

Row: TypeAlias = dict[str, Any]
# A table of a step; ``row`` is the point whose orbit, or whose multipliers, are wanted.
Table: TypeAlias = Callable[[Step, int | None], list[Row]]


def _whole(make: Callable[[Step], list[Row]]) -> Table:
    return lambda step, row: make(step)


def _of_point(make: Callable[[Step, int], list[Row]]) -> Table:
    return lambda step, row: make(step, row or 0)


_OF_ORBITS: dict[str, Table] = {
    "points": _whole(list_points),
    "special": _whole(list_special_points),
    "orbit": _of_point(list_orbit),
    "multipliers": list_multipliers,
}
_OF_EQUILIBRIA: dict[str, Table] = {
    "points": _whole(list_equilibria),
    "special": _whole(list_special_equilibria),
    "roots": list_roots,
}
_OF_ATTRACTORS: dict[str, Table] = {"points": _whole(list_attractors), "returns": _whole(list_returns)}
_TABLES: dict[str, Mapping[str, Table]] = {
    "orbit": _OF_ORBITS,
    "continue": _OF_ORBITS,
    "equilibrium": _OF_EQUILIBRIA,
    "equilibria": _OF_EQUILIBRIA,
    "simulate": {"trajectory": _of_point(list_trajectory), "events": _of_point(list_events)},
    "explore": {
        "branches": _whole(list_branches),
        "unexplained": _whole(list_unexplained),
        "motions": _whole(list_motions),
        "tori": _whole(list_tori),
    },
    "precision": {"precision": _whole(list_settings)},
    "sweep": _OF_ATTRACTORS,
    "basin": {**_OF_ATTRACTORS, "cells": _whole(list_cells)},
}
_DEFAULT: dict[str, Table] = {"points": _whole(list_columns)}
# The order in which tables are named.
NAMES = (
    *("points", "special", "orbit", "multipliers", "roots", "trajectory", "events", "precision", "returns", "cells"),
    *("branches", "unexplained", "motions", "tori"),
)


def register_tables(kind: str, tables: Mapping[str, Table]) -> None:
    """Say which tables steps of a kind have, the main one first."""
    _TABLES[kind] = tables


def forget_tables(kind: str) -> None:
    """Forget tables that :func:`register_tables` made known."""
    _TABLES.pop(kind, None)


def list_tables(kind: str) -> list[str]:
    """Return the names of the tables of a kind of step."""
    own = _TABLES.get(kind, _DEFAULT)
    return [name for name in dict.fromkeys((*NAMES, *own)) if name in own]


def list_all_tables() -> list[str]:
    """Return the names of all tables that there are."""
    return list(dict.fromkeys((*NAMES, *(name for own in _TABLES.values() for name in own))))


def find_main_table(kind: str) -> str:
    """Return the name of the table that a kind of step shows first."""
    return next(iter(_TABLES.get(kind, _DEFAULT)))


def make_table(step: Step, name: str, row: int | None = None) -> list[Row]:
    """Return a table of ``step``; ``row`` is the point whose orbit, or whose multipliers, are wanted.

    Raises
    ------
    ResultsError
        If there is no such table, or none of this kind of step, or the step no such point, or its multipliers were not
        computed.
    """
    own = _TABLES.get(step.kind, _DEFAULT)
    if name not in own:
        has = list_tables(step.kind)
        raise ResultsError(
            f"step '{step.name}' is a {step.kind} step and has no table '{name}'{suggest(str(name), has)} "
            f"(it has: {', '.join(has)})"
        )
    return own[name](step, row)
