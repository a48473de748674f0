"""What keeps an orbit's equations from having finite values."""

from __future__ import annotations

import numpy as np
import sympy

from pddecont.codegen import find_non_finite
from pddecont.model import differentiate
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.residual import group_by_mode


def explain_not_finite(orbit: Orbit, *, derivatives: bool = False) -> str:
    """Return which of the model's expressions has no finite value along an orbit; its ``derivatives`` if asked for."""
    numeric, model, reads, p = orbit.numeric, orbit.numeric.model, orbit.equation_reads, orbit.parameters
    free = (model.parameter_symbols[i] for i in orbit.problem.free_index)
    symbols = (*model.state_symbols, *model.read_symbols, *free)

    def name_parts(what: str, expr: sympy.Expr) -> list[tuple[str, sympy.Expr]]:
        if not derivatives:
            return [(what, expr)]
        return [(f"the derivative of {what} in {s}", differentiate(expr, s, model.chain)) for s in symbols]

    one = np.zeros(1), np.zeros((numeric.n_states, 1)), np.zeros((len(model.read_symbols), 1))
    constants = [("a delay", d) for d in model.delays]
    constants += [("the forcing period", model.period)] if model.period is not None else []
    parts = [part for what, expr in constants for part in name_parts(what, expr)]
    text = find_non_finite(numeric, parts, *one, p) if parts else ""
    for delay in model.varying:
        parts = name_parts(f"the delay {delay}", delay)
        text = text or find_non_finite(numeric, parts, reads.t, reads.x, reads.xd, p)
    for mode, points in group_by_mode(orbit.problem):
        rates = zip(model.states, model.modes[mode], strict=True)
        parts = [part for state, f in rates for part in name_parts(f"{state}' of mode '{mode}'", f)]
        at = reads.t[points], reads.x[:, points], reads.xd[:, points]
        text = text or find_non_finite(numeric, parts, *at, p)
    for s, segment in enumerate(orbit.signature.segments):
        after = zip(model.states, model.resets[segment.reset], strict=True)
        parts = [part for state, g in after for part in name_parts(f"{state} of reset '{segment.reset}'", g)]
        function = model.events[segment.event].function if segment.event else None
        parts += name_parts(f"event '{segment.event}'", function) if function is not None else []
        end = orbit.mesh.n_collocation + np.array([s])
        text = text or find_non_finite(numeric, parts, reads.t[end], reads.x[:, end], reads.xd[:, end], p)
    return text or "the orbit's equations have no finite values here"
