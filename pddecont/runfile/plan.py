"""A run file with its model: everything resolved and checked before anything is computed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import MeshRule
from pddecont.delay import DelayMethod
from pddecont.errors import Problem, RunError
from pddecont.model import Model
from pddecont.orbit import Monitor
from pddecont.runfile.durations import find_wrong_durations
from pddecont.runfile.fields import Delay, Mesh, Source
from pddecont.runfile.formula import ParameterFormula

Array = NDArray[np.float64]
S = TypeVar("S", covariant=True)


@dataclass(frozen=True, eq=False)
class PlannedStep(Generic[S]):
    """One step of a run.

    Attributes
    ----------
    settings
        What the step is to do, as its kind resolves it.
    source
        Where it starts (None: it starts from nothing).
    assignments
        Parameters that the step sets itself, in order, over those that it starts from.
    chooses
        Whether the run's accuracy decides its delay and mesh.
    fields
        What the file says of it, as JSON.
    files
        Fingerprints of the files of data that it has read, by their names in the file.
    """

    name: str
    kind: str
    settings: S
    source: Source | None
    assignments: Mapping[str, ParameterFormula]
    delay: DelayMethod
    rule: MeshRule
    chooses: bool
    fields: Mapping[str, Any]
    files: Mapping[str, str] = field(default_factory=dict)

    @property
    def mesh_settings(self) -> str:
        """What decides the step's meshes, to tell whether a recorded mesh can be used again."""
        return repr((self.rule, self.delay))

    def with_choice(self, delay: Delay, mesh: Mesh) -> PlannedStep[S]:
        """Return the step with another delay and mesh than the run's."""
        fields = {"delay": delay.model_dump(mode="json"), "mesh": mesh.model_dump(mode="json")}
        return replace(self, delay=delay.make_method(), rule=mesh.make_rule(), fields={**self.fields, **fields})


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked run; ``parameters`` are the run's values, ``base`` the folder that its paths are relative to.

    ``shared`` holds, as JSON, what the file says for all steps and their numbers depend on. ``inputs`` are the paths of
    the files that were read, by what they are in words.
    """

    model: Model
    numeric: NumericModel
    parameters: Array
    accuracy: float | None
    monitors: Mapping[str, Monitor]
    steps: tuple[PlannedStep[Any], ...]
    shared: Mapping[str, Any]
    warnings: tuple[Problem, ...]
    model_text: str
    run_text: str
    source: str
    base: Path
    inputs: Mapping[str, str]

    def find_step(self, name: str) -> PlannedStep[Any]:
        """Return the step of a name."""
        return next(step for step in self.steps if step.name == name)

    def name_values(self, p: Array) -> dict[str, float]:
        """Return parameters by name."""
        return dict(zip(self.model.parameters, p.tolist(), strict=True))

    def set_parameters(self, step: PlannedStep[Any], start: Array) -> Array:
        """Return the parameters of ``step``: those that it starts from, then its own.

        Raises
        ------
        RunError
            If a delay is negative with them, or the forcing period is no length of time.
        """
        p = start.copy()
        for name, formula in step.assignments.items():
            p[self.numeric.parameter_index(name)] = formula.evaluate(self.name_values(p))
        p = self.numeric.with_fixed(p)
        for message, _ in find_wrong_durations(self.model, self.name_values(p)):
            raise RunError.at(self.source, 0, 0, f"step '{step.name}': {message}")
        return p

    def describe_settings(self, step: PlannedStep[Any]) -> str:
        """Return all that decides a step's numbers besides the model, as JSON, to compare with at --resume."""
        data = {"step": step.fields, **self.shared, "parameters": self.parameters.tolist()}
        files = {"files": dict(step.files)} if step.files else {}
        return json.dumps({**data, **files, "left_out": self.model.left_out.as_data()}, sort_keys=True)
