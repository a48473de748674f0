"""How a branch of equilibria goes on at a boundary equilibrium, on the surface of an event that ends its mode.

Another mode may have an equilibrium at the same point: across a surface where the field is continuous, or along the
surface where it slides. Each of the two is one of its mode on one side of the point. If they are so for parameters on
different sides the branch persists; if on the same side two equilibria meet and vanish: a nonsmooth fold.

Reference: di Bernardo, Nordmark, Olivar, Physica D 237 (2008) 119-136.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import CurvePoint, find_tangent
from pddecont.equilibrium.equations import (
    Equilibrium,
    EquilibriumCurve,
    EquilibriumEvaluation,
    EquilibriumSystem,
    solve_equilibrium,
)
from pddecont.equilibrium.sides import list_sides
from pddecont.errors import ConvergenceError
from pddecont.model import IDENTITY

Array = NDArray[np.float64]
PERSISTENCE, NONSMOOTH_FOLD = "persistence", "nonsmooth fold"
# Two equilibria nearer than this, relative to their sizes, are one; on a surface is what is nearer than this.
SAME = 1e-7
# How far along its tangent it is looked on which side an equilibrium lies, in scaled unknowns.
AHEAD = 1e-4


@dataclass(frozen=True, eq=False)
class WayOn:
    """Where a branch goes on at a boundary equilibrium, and what that is called."""

    point: CurvePoint[EquilibriumEvaluation]
    nature: str


def find_way_on(point: CurvePoint[EquilibriumEvaluation], event: str) -> WayOn | None:
    """Return where the branch goes on at a boundary equilibrium on the surface of an event; None where it ends."""
    at = point.at.equilibrium
    model, system = at.motion.numeric.model, point.system
    assert isinstance(system, EquilibriumCurve), "equilibria have no mesh"
    inner = system.inner
    ending = [s for s in model.list_segments(at.motion.mode) if s.event == event]
    others = dict.fromkeys(s.to for s in ending if s.reset == IDENTITY and s.to != at.motion.mode)
    onward = float(np.sign(point.tangent[-1])) or 1.0
    own = _enter(inner, at, at.motion.mode)
    if own is not None and inner.scaling.dot(own.tangent, point.tangent) > 0.0:
        # The branch was beyond the surface and comes into its mode.
        return WayOn(own, PERSISTENCE)
    for mode in others:
        found = _enter(inner, at, mode)
        if found is not None:
            same_way = float(np.sign(found.tangent[-1])) == onward
            return WayOn(found, PERSISTENCE if same_way else NONSMOOTH_FOLD)
    return None


def _enter(inner: EquilibriumSystem, at: Equilibrium, mode: str) -> CurvePoint[EquilibriumEvaluation] | None:
    """Return the equilibrium of a mode at the same point with its tangent into the mode; None where it has none."""
    system = inner.enter(mode)
    try:
        found, _, _ = solve_equilibrium(replace(at, motion=system.problem.motion))
    except ConvergenceError:
        return None
    if np.max(np.abs(found.states - at.states) / inner.sizes) > SAME:
        return None
    x = system.problem.join(found)
    here, towards = system.at(x), np.zeros(len(x))
    towards[-1] = 1.0
    try:
        tangent = find_tangent(here, system.scaling, towards)
    except ConvergenceError:
        return None
    ways = [way for way in (1.0, -1.0) if _is_inside(system, x + way * AHEAD * tangent)]
    if len(ways) != 1:
        return None
    return CurvePoint(EquilibriumCurve(system), here, None, ways[0] * tangent)


def _is_inside(system: EquilibriumSystem, x: Array) -> bool:
    """Return whether an equilibrium lies in its mode."""
    at = system.problem.split(x)
    return all(side.measure(at) >= 0.0 for side in list_sides(at.motion.numeric.model, at.motion.mode))
