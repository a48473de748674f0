"""Where an exploration's first motions are: at a few parameters, in the slice that its branches are in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from pddecont.runfile import Plan, PlannedStep
from pddecont.steps.explore import ExploreSettings

Array = NDArray[np.float64]
# Parameter values at which a few motions tell how far and how fast they go.
N_PILOTS = 5


def choose_slice(plan: Plan, step: PlannedStep[ExploreSettings]) -> dict[str, float]:
    """Return the value of the second parameter at which branches in the first are: its own, or amid its range."""
    p = plan.set_parameters(step, plan.parameters)
    found = {}
    for name, (low, high) in list(step.settings.over.items())[1:]:
        own = float(p[plan.numeric.parameter_index(name)])
        found[name] = own if low <= own <= high else 0.5 * (low + high)
    return found


def list_pilots(plan: Plan, step: PlannedStep[ExploreSettings], at: Mapping[str, float]) -> Iterable[Array]:
    """Yield the parameter points of the first few motions."""
    name, (low, high) = next(iter(step.settings.over.items()))
    for value in np.linspace(low, high, N_PILOTS):
        p = plan.set_parameters(step, plan.parameters)
        for key, number in {**at, name: value}.items():
            p[plan.numeric.parameter_index(key)] = number
        yield plan.numeric.with_fixed(p)
