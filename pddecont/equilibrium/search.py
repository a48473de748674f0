"""All equilibria in a box of states, of several modes: zeros of f(x, ..., x; p), and on surfaces of u_j as well.

In a mode that slides the equations are those of ``constant_motion``, with one more unknown mu_j a surface: it is zero
at each solution, and has no width in the boxes that are searched.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.equilibrium.constant_motion import ConstantMotion
from pddecont.equilibrium.equations import Equilibrium, solve_equilibrium
from pddecont.equilibrium.rest_expressions import Box, find_rest_expressions
from pddecont.equilibrium.sides import list_sides
from pddecont.errors import ConvergenceError
from pddecont.intervals import BUDGET, Enclosure, Zeros, find_zeros

Array = NDArray[np.float64]
Resting: TypeAlias = Mapping[sympy.Symbol, sympy.Expr]
# Boxes that equations are given at least, where those of many modes share the budget.
LEAST = 2_000


@dataclass(frozen=True, eq=False)
class FoundEquilibrium:
    """An equilibrium, its error relative to the sizes of the states, and the steps of Newton's method to it."""

    at: Equilibrium
    error: float
    n_iterations: int


@dataclass(frozen=True, eq=False)
class Place:
    """A box from ``low`` to ``high`` (n_states,) in which a ``mode`` may have equilibria that are not known.

    They are all virtual if the mode is known not to hold there (``virtual``).
    """

    mode: str
    low: Array
    high: Array
    virtual: bool


@dataclass(frozen=True, eq=False)
class Findings:
    """The equilibria in a box; all of them if no place is ``undecided``, all but virtual ones if such places are."""

    equilibria: list[FoundEquilibrium]
    undecided: list[Place]


@dataclass(frozen=True)
class RestEquations:
    """What is zero at an equilibrium: the field, and the functions of the surfaces that a mode slides along."""

    field: tuple[sympy.Expr, ...]
    surfaces: tuple[sympy.Expr, ...]

    def enclose(self, motion: ConstantMotion, p: Array) -> Enclosure:
        """Return the equations over boxes of states and one mu a surface, as many as unknowns."""
        model = motion.numeric.model
        states, forces = model.state_symbols, tuple(sympy.Dummy(real=True) for _ in self.surfaces)
        pushed = [
            f + sum((mu * u.diff(x) for mu, u in zip(forces, self.surfaces, strict=True)), sympy.S.Zero)
            for f, x in zip(self.field, states, strict=True)
        ]
        constants = dict(zip(model.parameter_symbols, p.tolist(), strict=True))
        return Enclosure((*pushed, *self.surfaces), (*states, *forces), constants)


def make_rest_equations(motion: ConstantMotion, resting: Resting) -> RestEquations:
    """Return the equations of a mode with what is read of the past at rest in place of each read."""
    surfaces = tuple(_find_function(motion, name, resting) for name in motion.surfaces)
    return RestEquations(tuple(f.xreplace(resting) for f in motion.numeric.model.modes[motion.mode]), surfaces)


def _find_function(motion: ConstantMotion, event: str, resting: Resting) -> sympy.Expr:
    """Return the function of an event at rest."""
    function = motion.numeric.model.events[event].function
    assert function is not None, f"event {event} is a delayed event"
    return function.xreplace(resting)


def find_equilibria(motions: Iterable[ConstantMotion], p: Array, low: Array, high: Array) -> Findings:
    """Return the equilibria of modes of a model between ``low`` and ``high`` (n_states,).

    Equations that modes have in common are searched once. Each equilibrium is that of one mode, and may lie where
    another mode holds.

    Raises
    ------
    ConvergenceError
        If the model reads an integral of which no closed form is known.
    """
    by_equations: dict[RestEquations, list[ConstantMotion]] = {}
    resting: Resting | None = None
    for motion in motions:
        # All motions are of one model.
        resting = resting or find_rest_expressions(motion.reads, Box(p, low, high))
        by_equations.setdefault(make_rest_equations(motion, resting), []).append(motion)
    budget = max(BUDGET // max(len(by_equations), 1), LEAST)
    findings = Findings([], [])
    for equations, sharing in by_equations.items():
        zeros = _search(equations, sharing[0], p, low, high, budget)
        for motion in sharing:
            _add(findings, motion, zeros, p, resting or {})
    return findings


def _search(equations: RestEquations, motion: ConstantMotion, p: Array, low: Array, high: Array, budget: int) -> Zeros:
    enclosure, none = equations.enclose(motion, p), np.zeros(len(equations.surfaces))
    sizes = np.concatenate([high - low, _measure_forces(enclosure, low, high)])
    return find_zeros(enclosure, np.concatenate([low, none]), np.concatenate([high, none]), sizes, budget)


def _measure_forces(enclosure: Enclosure, low: Array, high: Array) -> Array:
    """Return the size of each mu: as the field changes in the region, relative to the gradient of its surface."""
    n, m = len(low), len(enclosure.variables) - len(low)
    middle = np.concatenate([0.5 * (low + high), np.zeros(m)])[:, None]
    slopes = np.nan_to_num(enclosure.derivatives(middle, middle)[1].middle[:, :, 0], posinf=0.0, neginf=0.0)
    change, gradients = np.max(np.abs(slopes[:n, :n]) @ (high - low)), np.max(np.abs(slopes[n:, :n]), axis=1)
    return (change or 1.0) / np.where(gradients > 0.0, gradients, 1.0)


def _add(findings: Findings, motion: ConstantMotion, zeros: Zeros, p: Array, resting: Resting) -> None:
    """Add what was found to the equilibria of a mode."""
    n = motion.n_states
    places = [(low[:n], high[:n]) for low, high in zip(zeros.undecided.low.T, zeros.undecided.high.T, strict=True)]
    for point in zeros.points:
        try:
            findings.equilibria.append(FoundEquilibrium(*solve_equilibrium(Equilibrium(motion, point[:n], p))))
        except ConvergenceError:
            places.append((point[:n], point[:n]))
    findings.undecided.extend(
        Place(motion.mode, low, high, not _may_hold(motion, p, low, high, resting)) for low, high in places
    )


def _may_hold(motion: ConstantMotion, p: Array, low: Array, high: Array, resting: Resting) -> bool:
    """Return whether a motion that rests somewhere in a box may lie on the near side of all that ends its mode."""
    model = motion.numeric.model
    sides = list_sides(model, motion.mode)
    constants = dict(zip(model.parameter_symbols, p.tolist(), strict=True))
    near = tuple(-side.sign * _find_function(motion, side.event, resting) for side in sides)
    if not near:
        return True
    values = Enclosure(near, model.state_symbols, constants).values(low[:, None], high[:, None])
    return bool(np.all(values.high >= 0.0))
