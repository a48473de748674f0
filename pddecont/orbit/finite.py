"""What keeps an orbit's equations from having finite values."""

from __future__ import annotations

import numpy as np
import sympy

from pddecont.model.diagnosis import not_finite
from pddecont.orbit.problem import OrbitProblem, Reads
from pddecont.orbit.residual import mode_sites


def why_not_finite(problem: OrbitProblem, sites: Reads, *, derivatives: bool = False) -> str:
    """Return which of the model's expressions has no finite value along the orbit, in words; its ``derivatives`` if they are asked for."""
    numeric, model = problem.numeric, problem.numeric.model
    symbols = (*model.state_symbols, *model.delayed_symbols, *(model.parameter_symbols[i] for i in problem.free_index))

    def named(what: str, expr: sympy.Expr) -> list[tuple[str, sympy.Expr]]:
        return [(f"the derivative of {what} in {s}", expr.diff(s)) for s in symbols] if derivatives else [(what, expr)]

    one = np.zeros(1), np.zeros((numeric.n_states, 1)), np.zeros((len(model.delayed), 1))
    constants = [("a delay", d) for d in model.delays] + ([("the forcing period", model.period)] if model.period is not None else [])
    text = not_finite(numeric, [n for what, expr in constants for n in named(what, expr)], *one, sites.p) if constants else ""
    for mode, points in mode_sites(problem):
        rates = [n for state, f in zip(model.states, model.modes[mode], strict=True) for n in named(f"{state}' of mode '{mode}'", f)]
        text = text or not_finite(numeric, rates, sites.t[points], sites.x[:, points], sites.xd[:, points], sites.p)
    for s, segment in enumerate(problem.segments):
        after = [n for state, g in zip(model.states, model.resets[segment.reset], strict=True)
                 for n in named(f"{state} of reset '{segment.reset}'", g)]  # fmt: skip
        function = model.events[segment.event].function if segment.event else None
        after += named(f"event '{segment.event}'", function) if function is not None else []
        end = problem.mesh.n_collocation + np.array([s])
        text = text or not_finite(numeric, after, sites.t[end], sites.x[:, end], sites.xd[:, end], sites.p)
    return text or "the orbit's equations have no finite values here"
