"""All equilibria in a box, as an equilibrium step records them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pddecont.equilibrium import (
    ConstantMotion,
    DelayedSwitching,
    Equilibrium,
    Findings,
    FoundEquilibrium,
    find_delayed_switchings,
    find_equilibria,
    find_passed_side,
)
from pddecont.errors import RunError
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.equilibrium import EquilibriumSettings

# States that differ by less than this part of the box are equal where equilibria are put in order.
EQUAL = 1e-9
# Modes that are searched, at most.
MOST_MODES = 500


def search_box(context: Context, step: PlannedStep[EquilibriumSettings]) -> Findings:
    """Return the equilibria in a step's box, in the mode asked for or in all; first those that lie in their mode."""
    plan, settings = context.plan, step.settings
    assert settings.box is not None, "only asked of steps that search"
    modes = _list_modes(context, step) if settings.mode is None else [settings.mode]
    low, high = (np.array([settings.box[name][k] for name in plan.model.states]) for k in (0, 1))
    p = plan.set_parameters(step, plan.parameters)
    found = find_equilibria([ConstantMotion(plan.numeric, mode, step.delay) for mode in modes], p, low, high)

    def place(one: FoundEquilibrium) -> tuple[Any, ...]:
        states = np.round((one.at.states - low) / (EQUAL * (high - low)))
        return find_passed_side(one.at) is not None, *states.tolist(), modes.index(one.at.motion.mode)

    return Findings(sorted(found.equilibria, key=place), found.undecided)


def _list_modes(context: Context, step: PlannedStep[EquilibriumSettings]) -> list[str]:
    """Return all modes of the model; raise RunError if they are too many to be searched one after another."""
    model = context.plan.model
    if model.derived is not None and not model.derived.build_every(MOST_MODES):
        raise RunError.at(
            context.plan.source,
            0,
            0,
            f"step '{step.name}': the model has {model.derived.n_modes} modes, more than the {MOST_MODES} that are "
            "searched; name one with 'mode'",
        )
    return list(model.modes)


def list_switchings(context: Context, step: PlannedStep[EquilibriumSettings]) -> list[DelayedSwitching]:
    """Return the places in a step's box at which a law that switches on past values cannot rest."""
    plan, settings = context.plan, step.settings
    assert settings.box is not None, "only asked of steps that search"
    low, high = (np.array([settings.box[name][k] for name in plan.model.states]) for k in (0, 1))
    p = plan.set_parameters(step, plan.parameters)
    found: dict[tuple[Any, ...], DelayedSwitching] = {}
    for mode in _list_modes(context, step) if settings.mode is None else [settings.mode]:
        guess = Equilibrium(ConstantMotion(plan.numeric, mode, step.delay), 0.5 * (low + high), p)
        for one in find_delayed_switchings(guess):
            if np.all((one.states >= low) & (one.states <= high)):
                place = np.round((one.states - low) / (EQUAL * (high - low)))
                found.setdefault((*sorted(one.modes), *place.tolist()), one)
    return list(found.values())


def make_switching_meta(switchings: Sequence[DelayedSwitching]) -> dict[str, Any]:
    """Return what a step says of places at which a law that switches on past values cannot rest."""
    return {
        "switchings": [
            {"event": one.event, "modes": list(one.modes), "states": one.states.tolist()} for one in switchings
        ]
    }


def make_search_meta(step: PlannedStep[EquilibriumSettings], findings: Findings) -> dict[str, Any]:
    """Return what a step says of its search: the box, and the boxes in which equilibria may have been missed."""
    box = step.settings.box
    assert box is not None, "only asked of steps that search"
    undecided = [
        {"mode": place.mode, "low": place.low.tolist(), "high": place.high.tolist(), "virtual": place.virtual}
        for place in findings.undecided
    ]
    return {"search": {name: list(limits) for name, limits in box.items()}, "undecided": undecided}
