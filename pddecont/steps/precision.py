"""The ``precision`` step: what quantities of an orbit, or of a simulation's end, cost at which accuracy.

Every orbit is solved from the same rough guess: the orbit that the step starts from, on a coarse mesh of low degree. The error of a
quantity is its distance from the closed form given, or from the finest solution of the delay equation itself, relative to its size.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.direct import Direct
from pddecont.errors import ConvergenceError
from pddecont.model.chain_states import with_chain_states
from pddecont.model.codegen import NumericModel
from pddecont.orbit.curve import settle
from pddecont.orbit.meshing import MeshRule, remeshed
from pddecont.orbit.monitors import parse_monitor
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.stages import with_stages
from pddecont.results.layout import Column, StepSpec
from pddecont.results.precision import cheapest_text
from pddecont.results.reader import Step as RecordedStep
from pddecont.results.writer import StepWriter
from pddecont.steps.context import Context, orbit_at, settings_text
from pddecont.steps.cost import Cost, measured
from pddecont.steps.plan import Plan, delay_method
from pddecont.steps.schema import Delay, Precision, Step
from pddecont.steps.settings import OrbitSetting, RunSetting, orbit_settings, run_settings
from pddecont.steps.units import units_of

Array = NDArray[np.float64]
ROUGH = MeshRule(3, intervals=12)
# The two finest meshes; each is tried until rounding allows a tolerance.
FINEST = ((12, (1e-12, 1e-11, 1e-10)), (10, (1e-11, 1e-10, 1e-9)))
FINEST_RUNS = (RunSetting("explicit", 3e-14), RunSetting("explicit", 3e-13))
REFERENCE = "reference"
DIRECT = Delay.model_validate({"method": "direct"})


@dataclass(frozen=True, eq=False)
class Found:
    """What one setting found: the quantities, the states at the segments' ends (of orbits), and how large the computation was."""

    values: Array
    ends: Array
    time: Array
    states: Array
    n_unknowns: int = 0
    n_intervals: int = 0
    n_iterations: int = 0
    n_steps: int = 0


@dataclass(frozen=True, eq=False)
class Case:
    """One row: how it is called, its numbers, and what computes it."""

    family: str
    label: str
    numbers: dict[str, Any]
    compute: Callable[[], Found]


def run_precision(context: Context, step: Step, recorded: RecordedStep | None) -> None:
    """Solve the reference, then one setting after another; each is a row of the results."""
    plan, body = context.plan, step.precision
    assert body is not None
    cases, finest, check = (_of_runs if _is_simulated(context, step) else _of_orbits)(context, step)
    context.reporter.progress("the reference")
    best, cost = measured(finest.compute, body.repeats)
    known = np.array([plan.number(body.reference[name]) if name in body.reference else np.nan for name in body.quantities])
    reference = _Reference(known, best, check.compute())
    spec = _spec(plan, step, body, best)
    kept = len(recorded) if recorded is not None else 0
    kept_rows = {name: int(recorded.orbits[f"{name}_end"][kept - 1]) if recorded is not None and kept else 0 for name in spec.orbits}
    with StepWriter(context.path, spec, kept=kept, kept_rows=kept_rows) as writer:
        if kept == 0:
            writer.append(*_row(finest, best, cost, reference))
        for i, case in enumerate(cases):
            if i + 1 < kept:
                continue
            try:
                found, cost = measured(case.compute, body.repeats)
                row = _row(case, found, cost, reference)
            except ConvergenceError as exc:
                row = _row(case, None, None, reference, str(exc))
            writer.append(*row)
            context.reporter.advance(i + 1, len(cases), "settings")
        writer.terminate(f"{len(cases)} settings against {reference.text(list(body.quantities))}")
    done = context.recorded(step.name)
    context.reporter.done(f"{done.termination[0]}; {cheapest_text(done)}")


@dataclass(frozen=True, eq=False)
class _Reference:
    """Closed forms (NaN where none is given) and the finest solution, with another mesh's to check it."""

    known: Array
    best: Found
    other: Found

    @property
    def values(self) -> Array:
        """The quantities."""
        return np.where(np.isnan(self.known), self.best.values, self.known)

    @property
    def scale(self) -> Array:
        """Sizes that errors are relative to."""
        return np.where(self.values == 0.0, 1.0, np.abs(self.values))

    @property
    def errors(self) -> Array:
        """How far the finest solution is from the closed form, or from the other mesh's, relative to the size."""
        against = np.where(np.isnan(self.known), self.other.values, self.known)
        return np.abs(self.best.values - against) / self.scale

    def text(self, names: Sequence[str]) -> str:
        """Return in words where the reference comes from and how good it is."""
        def worst(which: NDArray[np.bool_]) -> str:
            listed = ", ".join(name for name, chosen in zip(names, which, strict=True) if chosen)
            return f"{listed}: {np.max(self.errors[which]):.1e}"

        given, parts = ~np.isnan(self.known), []
        if np.any(given):
            parts.append(f"closed forms (the finest solution differs by {worst(given)})")
        if not np.all(given):
            parts.append(f"the finest solution (two meshes differ by {worst(~given)})")
        return " and ".join(parts)


def _is_simulated(context: Context, step: Step) -> bool:
    source = step.source
    above = {s.name: s for s in context.plan.run.steps}
    return source is not None and source.file is None and above[source.step].kind == "simulate"


def _spec(plan: Plan, step: Step, body: Precision, best: Found) -> StepSpec:
    n, m = len(body.quantities), len(plan.model.states)
    points = {
        "family": Column("S48"), "setting": Column("S96"), "degree": Column("i4"), "intervals": Column("i4"), "tolerance": Column("f8"),
        "n": Column("i8"), "values": Column("f8", (n,)), "errors": Column("f8", (n,)), "error": Column("f8"), "distance": Column("f8"),
        "wall": Column("f8"), "wall_low": Column("f8"), "wall_high": Column("f8"), "cpu": Column("f8"), "memory": Column("i8"),
        "n_unknowns": Column("i8"), "n_intervals": Column("i8"), "n_iterations": Column("i8"), "n_steps": Column("i8"),
        "note": Column("S160"), "parameters": Column("f8", (len(plan.model.parameters),)),
    }  # fmt: skip
    meta = {"quantities": list(body.quantities), "states": list(plan.model.states), "parameters": list(plan.model.parameters),
            "closed": list(body.reference), "ends": best.ends.tolist(), "repeats": body.repeats, "model": plan.model.name,
            "units": units_of(plan),
            "settings": settings_text(plan, step)}  # fmt: skip
    return StepSpec(step.name, "precision", points, {"time": Column("f8"), "states": Column("f8", (m,))}, meta)


def _row(case: Case, found: Found | None, cost: Cost | None, reference: _Reference,
         note: str = "") -> tuple[dict[str, Any], dict[str, Array]]:  # fmt: skip
    n, nothing = len(reference.values), float("nan")
    points: dict[str, Any] = {"family": case.family.encode(), "setting": case.label.encode()[:96], "degree": 0, "intervals": 0,
                              "tolerance": nothing, "n": 0, **case.numbers, "note": note.encode()[:160]}  # fmt: skip
    if found is None or cost is None:
        failed = {"values": np.full(n, nothing), "errors": np.full(n, nothing), "error": nothing, "distance": nothing, "wall": nothing,
                  "wall_low": nothing, "wall_high": nothing, "cpu": nothing, "memory": 0, "n_unknowns": 0, "n_intervals": 0,
                  "n_iterations": 0, "n_steps": 0}  # fmt: skip
        return points | failed, {"time": np.zeros(0), "states": np.zeros((0, reference.best.states.shape[1]))}
    best = reference.best
    errors = reference.errors if found is best else np.abs(found.values - reference.values) / reference.scale
    same = found.ends.shape == best.ends.shape and len(best.ends) > 0
    # eq. (4.1) of the paper
    distance = float(np.sum(np.linalg.norm(found.ends - best.ends, axis=1))) if same else nothing
    return points | {
        "values": found.values, "errors": errors, "error": float(np.max(errors)), "distance": distance, "wall": cost.wall,
        "wall_low": cost.wall_low, "wall_high": cost.wall_high, "cpu": cost.cpu, "memory": cost.memory, "n_unknowns": found.n_unknowns,
        "n_intervals": found.n_intervals, "n_iterations": found.n_iterations, "n_steps": found.n_steps,
    }, {"time": found.time, "states": found.states}  # fmt: skip


def _of_orbits(context: Context, step: Step) -> tuple[list[Case], Case, Case]:
    """Return the cases of a step that compares orbits, the reference and what checks it."""
    plan, body = context.plan, step.precision
    assert body is not None
    problem, x = orbit_at(context, step, body.from_)
    problem, solution = settle(problem, x, context.rule_of(step))
    rough = remeshed(replace(problem, delay=Direct(False)), solution.x, ROUGH)
    at = {"parameters": problem.parameters}

    @cache
    def with_states(order: int, n: int) -> NumericModel:
        return NumericModel(with_chain_states(plan.model, order, n))

    def case(setting: OrbitSetting) -> Case:
        method = delay_method(setting.delay)
        numeric = with_states(setting.delay.order or 2, setting.n) if setting.explicit else plan.numeric
        rule = setting.rule
        how = f"{rule.intervals} intervals" if rule.intervals is not None else f"tolerance {rule.tol:g}"
        n = f" with n = {setting.n}" if setting.n else ""
        numbers = {**at, "degree": rule.degree, "intervals": rule.intervals or 0, "tolerance": rule.tol or np.nan, "n": setting.n}

        def compute() -> Found:
            if setting.explicit:
                guess = with_stages(*rough, numeric, setting.delay.order or 2, setting.n, rule)
            else:
                guess = remeshed(replace(rough[0], delay=method), rough[1], rule)
            return _found(plan, body, numeric, *guess, rule)

        return Case(setting.family, f"{setting.family}{n}, degree {rule.degree}, {how}", numbers, compute)

    def finest(degree: int, tolerances: Sequence[float]) -> Case:
        def compute() -> Found:
            for tol in tolerances[:-1]:
                try:
                    return case(OrbitSetting(DIRECT, False, MeshRule(degree, None, tol))).compute()
                except ConvergenceError:
                    continue
            return case(OrbitSetting(DIRECT, False, MeshRule(degree, None, tolerances[-1]))).compute()

        return Case(REFERENCE, f"{REFERENCE}: direct, degree {degree}", {**at, "degree": degree}, compute)

    return [case(s) for s in orbit_settings(body)], finest(*FINEST[0]), finest(*FINEST[1])


def _found(plan: Plan, body: Precision, numeric: NumericModel, problem: OrbitProblem, guess: Array, rule: MeshRule) -> Found:
    problem, solution = settle(problem, guess, rule)
    x, n = solution.x, len(plan.model.states)
    values = problem.layout.split(x)[0][:, :n]
    numbers = np.array([parse_monitor(numeric, name, text).value(problem, x) for name, text in body.quantities.items()])
    ends = values[problem.mesh.last_base] if problem.segments[0].event else np.zeros((0, n))
    return Found(numbers, ends, problem.mesh.base_times(problem.theta(x)), values, len(x), problem.mesh.n_intervals, solution.n_iterations)


def _of_runs(context: Context, step: Step) -> tuple[list[Case], Case, Case]:
    """Return the cases of a step that compares simulations, the reference and what checks it."""
    from pddecont.steps.integration import method_of
    from pddecont.steps.signals import signal_values
    from pddecont.steps.simulate import past_of, schedule, trajectory_of

    plan, body = context.plan, step.precision
    assert body is not None
    source = next(s for s in plan.run.steps if s.name == body.from_.step)
    assert source.simulate is not None
    own, p = method_of(plan, source, source.simulate), plan.step_parameters(source)
    t_end, stages, past = plan.number(source.simulate.t_end, p), [(-np.inf, p), *schedule(plan, source, p)], past_of(plan, source, p)

    def case(setting: RunSetting, family: str | None = None) -> Case:
        def compute() -> Found:
            # atol stays in its proportion to rtol.
            method = replace(own, rtol=setting.tolerance, atol=own.atol / own.rtol * setting.tolerance,
                             stiff=setting.integrator == "stiff")  # fmt: skip
            trajectory = trajectory_of(plan, source, method)
            end = trajectory(np.array([t_end]))
            values = signal_values(plan, body.quantities, trajectory, np.array([t_end]), end, stages, past)[0]
            return Found(values, np.zeros((0, len(plan.model.states))), np.array([t_end]), end, n_steps=trajectory.n_steps)

        name = family or setting.integrator
        return Case(name, f"{name}, tolerance {setting.tolerance:g}", {"parameters": p, "tolerance": setting.tolerance}, compute)

    finest, check = (case(setting, REFERENCE) for setting in FINEST_RUNS)
    return [case(s) for s in run_settings(body)], finest, check
