"""One row of a branch: what is recorded of an orbit, and the columns it goes to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.grazing import clearance
from pddecont.model.codegen import NumericModel
from pddecont.orbit.admissibility import event_profiles, objections
from pddecont.orbit.estimate import error_estimate
from pddecont.orbit.monitors import Monitor
from pddecont.orbit.problem import OrbitProblem, read
from pddecont.orbit.record import to_rows
from pddecont.results.layout import Column, StepSpec
from pddecont.stability.multipliers import Multipliers

Array = NDArray[np.float64]


def orbit_spec(name: str, kind: str, numeric: NumericModel, monitors: Sequence[Monitor], meta: Mapping[str, Any]) -> StepSpec:
    """Return the columns of a step that records orbits."""
    model, n = numeric.model, numeric.n_states
    points = {
        "kind": Column("S2"), "arclength": Column("f8"), "parameters": Column("f8", (len(model.parameters),)),
        "period": Column("f8"), "stable": Column("i1"), "admissible": Column("i1"), "error_estimate": Column("f8"),
        "monitors": Column("f8", (len(monitors),)), "clearance": Column("f8"), "n_iterations": Column("i8"),
        "step": Column("f8"), "n_periods": Column("i8"), "phase": Column("f8"), "n_unknowns": Column("i8"),
        "surfaces": Column("f8", (len(model.events), n + 1)), "n_unstable": Column("i4"), "trivial_error": Column("f8"),
        "note": Column("S32"), "side": Column("f8", (2,)),
    }  # fmt: skip
    orbits = {"time": Column("f8"), "states": Column("f8", (n,)), "segment": Column("i4"), "unknowns": Column("f8"),
              "tangent": Column("f8"), "mesh": Column("f8"), "signature": Column("u1"), "multipliers": Column("f8", (2,)),
              "delayed": Column("f8", (len(model.delayed),))}  # fmt: skip
    names = {"parameters": list(model.parameters), "states": list(model.states), "monitors": [m.name for m in monitors],
             "events": list(model.events), "model": model.name, "delayed": [s.name for s in model.delayed_symbols]}  # fmt: skip
    return StepSpec(name, kind, points, orbits, {**names, **meta})


def orbit_row(problem: OrbitProblem, x: Array, monitors: Sequence[Monitor], *, kind: str = "", arclength: float = 0.0,
              n_iterations: int = 0, step: float = 0.0, tangent: Array | None = None, stability: Multipliers | None = None,
              note: str = "", side: Array | None = None,
              widths: tuple[float, ...] = ()) -> tuple[dict[str, Any], dict[str, Array]]:  # fmt: skip
    """Return the row of points and the rows of orbits that record the orbit ``x``; ``widths`` are those of the free parameters' ranges."""
    profiles = event_profiles(problem, x)
    points = {
        "kind": kind.encode(), "arclength": arclength, "parameters": problem.numeric.with_fixed(problem.all_parameters(x)),
        "period": problem.period(x),
        "stable": -1 if stability is None or stability.lost else stability.stable,
        "n_unstable": -1 if stability is None or stability.lost else stability.n_unstable,
        "trivial_error": np.nan if stability is None else stability.trivial_error, "note": note.encode()[:32],
        "side": np.full(2, np.nan) if side is None else side, "admissible": not objections(problem, x, profiles),
        "error_estimate": error_estimate(problem, x, widths),
        "monitors": np.array([m.value(problem, x) for m in monitors]), "clearance": clearance(problem, x, profiles),
        "n_iterations": n_iterations, "step": step, "n_periods": problem.n_periods, "phase": problem.phase,
        "n_unknowns": len(x), "surfaces": surfaces(problem, x),
    }  # fmt: skip
    values = np.zeros(0, dtype=complex) if stability is None else stability.values
    rows = {"multipliers": np.stack([values.real, values.imag], axis=1), "delayed": delayed_values(problem, x)}
    return points, {**to_rows(problem, x, tangent), **rows}


def delayed_values(problem: OrbitProblem, x: Array) -> Array:
    """Return the delayed values at the base points, shape (n_base, n_delayed)."""
    mesh = problem.mesh
    base = mesh.basis.base
    places = mesh.grid(base)
    result = np.empty((mesh.n_base, len(problem.numeric.model.delayed)))
    result[mesh.base_index.ravel()] = read(problem, x, places).xd.T
    return result


def surfaces(problem: OrbitProblem, x: Array) -> Array:
    """Return each event surface a . z = b as the row (a, b), shape (n_events, n_states + 1); NaN where it is not a plane."""
    model, n = problem.numeric.model, problem.numeric.n_states
    result = np.full((len(model.events), n + 1), np.nan)
    p = problem.all_parameters(x)
    for i, event in enumerate(model.events.values()):
        if event.function is None or not event.function.free_symbols <= {*model.state_symbols, *model.parameter_symbols}:
            continue
        function = problem.numeric.event(event.name)
        d = function.derivatives(np.zeros(2), np.outer(np.ones(n), [0.0, 1.0]), np.zeros((len(model.delayed), 2)), p)
        rounding = 1e-14 * (1 + np.max(np.abs(d.dx), initial=0.0))
        if np.allclose(d.dx[:, 0], d.dx[:, 1], rtol=0, atol=rounding) and np.all(np.isfinite(d.value)):
            result[i] = 0.0
            result[i, function.structure().dx[1]], result[i, n] = d.dx[:, 0], -d.value[0, 0]
    return result
