"""What the steps of one run share: the plan, the results file, trajectories in memory, someone to tell."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import PddecontError, ResultsError
from pddecont.orbit.guess import timers_of
from pddecont.orbit.meshing import MeshRule, fits, moved_to, new_mesh
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.orbit.record import from_rows, mesh_from_row
from pddecont.results.reader import Results, read_results
from pddecont.results.reader import Step as RecordedStep
from pddecont.simulate.trajectory import Trajectory
from pddecont.simulate.workers import Workers
from pddecont.stability.multipliers import Known
from pddecont.steps.plan import Plan, mesh_rule
from pddecont.steps.schema import Source, Stability, Step

Array = NDArray[np.float64]
ROUNDING = 1e-12


class Reporter(Protocol):
    """Someone who wants to know how a run goes."""

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""
        ...

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""
        ...

    def advance(self, done: int, total: int, what: str) -> None:
        """Hear how many of a number of like things are done."""
        ...

    def note(self, text: str) -> None:
        """Hear something that a person would want to know while waiting."""
        ...

    def done(self, text: str) -> None:
        """Hear how a step ended."""
        ...


class Silent:
    """A reporter that listens and says nothing."""

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""

    def advance(self, done: int, total: int, what: str) -> None:
        """Hear how many of a number of like things are done."""

    def note(self, text: str) -> None:
        """Hear something that a person would want to know while waiting."""

    def done(self, text: str) -> None:
        """Hear how a step ended."""


@dataclass(eq=False)
class Context:
    """State of a run in progress."""

    plan: Plan
    path: Path
    reporter: Reporter
    workers: Workers = field(default_factory=Workers)
    trajectories: dict[str, tuple[Trajectory, Array]] = field(default_factory=dict)

    def recorded(self, name: str) -> RecordedStep:
        """Return a step as the results file holds it now."""
        return read_results(self.path, name).step(name)

    def source(self, source: Source) -> tuple[Results, RecordedStep]:
        """Return the recorded step that ``source`` names, in this run's file or another, and that file."""
        results = read_results(self.path if source.file is None else self.plan.base / source.file, source.step)
        return results, results.step(source.step)

    def rule_of(self, step: Step) -> MeshRule:
        """Return how a step makes its meshes."""
        return mesh_rule(step.mesh or self.plan.run.mesh)


def source_step(context: Context, source: Source) -> tuple[RecordedStep, int]:
    """Return the recorded step that a step starts from and the row of its point."""
    results, recorded = context.source(source)
    if recorded.kind not in ("orbit", "continue"):
        raise ResultsError(f"step '{source.step}' of {results.path} is a {recorded.kind} step and holds no orbits")
    row = recorded.row(source.point) if source.point else source.index or 0
    if row >= len(recorded):
        raise ResultsError(f"step '{source.step}' of {results.path} has {len(recorded)} points, no index {row}")
    return recorded, row


def attractor_step(context: Context, source: Source) -> RecordedStep | None:
    """Return the sweep or basin step that a step starts from, or None if it starts from something else."""
    recorded = context.source(source)[1]
    return recorded if recorded.kind in ("sweep", "basin") else None


def orbit_at(context: Context, step: Step, source: Source) -> tuple[OrbitProblem, Array]:
    """Return the recorded orbit that a step starts from, at the step's own delay method, mesh and parameters.

    Where those are the recorded orbit's own it solves the problem already; otherwise it is a guess.
    """
    plan = context.plan
    recorded, row = source_step(context, source)
    names = recorded.meta["parameters"]
    unknown = [name for name in plan.model.parameters if name not in names]
    if unknown or list(recorded.meta["states"]) != list(plan.model.states):
        raise ResultsError(f"step '{source.step}' comes from another model: it has parameters {', '.join(names)} and states "
                           f"{', '.join(recorded.meta['states'])}")  # fmt: skip
    at_row = dict(zip(names, recorded.points["parameters"][row], strict=True))
    old_p = np.array([at_row[name] for name in plan.model.parameters])
    try:
        problem, x, old = _as_recorded(plan, step, recorded, row, old_p)
    except (ValueError, IndexError, ZeroDivisionError, OverflowError) as exc:
        raise ResultsError(f"point {row} of step '{source.step}' is not an orbit of this model: {exc}; the file is damaged or was made by "
                           "a changed model") from exc  # fmt: skip
    if recorded.meta["mesh_settings"] == mesh_settings(plan, step) and fits(problem, x):
        return problem, x
    return moved_to(problem, x, old.theta(x), new_mesh(problem, problem.theta(x), context.rule_of(step)))


def _as_recorded(plan: Plan, step: Step, recorded: RecordedStep, row: int, old_p: Array) -> tuple[OrbitProblem, Array, OrbitProblem]:
    """Return the problem at the step's parameters, the unknowns as they are recorded, and the problem that they solve."""
    rows = recorded.orbit(row)
    old = OrbitProblem(
        plan.numeric, segments_of(plan, rows["signature"].tobytes().decode()), mesh_from_row(rows["mesh"]),
        plan.delay_method(step), old_p, (), int(recorded.points["n_periods"][row]), None,
        float(recorded.points["phase"][row]))  # fmt: skip
    x = from_rows(old, rows)
    durations = old.layout.split(x)[1]
    old = with_reference(replace(old, timers=timers_of(plan.numeric, old.segments, old_p, durations)), x)
    # Two events at one moment leave a segment of no duration, to rounding.
    if not np.all(np.isfinite(x)) or not np.min(durations) > -ROUNDING * np.sum(np.abs(durations)):
        raise ValueError("its unknowns are not finite, or a segment ends before it begins")
    return replace(old, parameters=plan.step_parameters(step, old_p)), x, old


def known_multipliers(choice: bool | Stability) -> Known | None:
    """Return what finds multipliers as a step asks for them, or None if it does not."""
    if isinstance(choice, Stability):
        return Known(choice.multipliers)
    return Known() if choice else None


def mesh_settings(plan: Plan, step: Step) -> str:
    """Return what decides a step's meshes, to tell whether a recorded mesh can be used again."""
    return repr((mesh_rule(step.mesh or plan.run.mesh), plan.delay_method(step)))


def choice_of(plan: Plan, step: Step) -> dict[str, str]:
    """Return, for a run with an accuracy, the delay and mesh of a step as text, so that steps that start from it can use them again."""
    if plan.run.accuracy is None or step.mesh is None:
        return {}
    used = {"delay": step.delay or plan.run.delay, "mesh": step.mesh}
    return {"choice": json.dumps({key: value.model_dump(mode="json", exclude_none=True) for key, value in used.items()})}


def with_reference(problem: OrbitProblem, x: Array) -> OrbitProblem:
    """Return the problem with the orbit ``x`` as the reference of its phase, where it needs one."""
    if problem.segments[0].event or problem.numeric.model.forced:
        return problem
    return replace(problem, reference=problem.layout.split(x)[0])


def segments_of(plan: Plan, names: str) -> Any:
    """Return the segments that a recorded signature names."""
    result = []
    for name in names.split():
        if name.startswith("("):
            result.append(eventless(name[1:-1]))
        elif name in plan.model.segments:
            result.append(plan.model.segments[name])
        else:
            raise PddecontError(f"the recorded orbit runs through segment '{name}', which this model does not have")
    return tuple(result)


def settings_text(plan: Plan, step: Step) -> str:
    """Return all that decides a step's numbers besides the model, as JSON, to compare with at --resume."""
    body: Mapping[str, Any] = step.model_dump(mode="json", by_alias=True)
    shared = plan.run.model_dump(mode="json", by_alias=True, include={"accuracy", "delay", "mesh", "monitors"})
    return json.dumps({"step": body, **shared, "parameters": plan.parameters.tolist(), "left_out": plan.model.left_out.as_data()},
                      sort_keys=True)  # fmt: skip
