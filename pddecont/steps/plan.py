"""A run file with its model: everything resolved and checked before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.chain import Chain
from pddecont.delay.chebyshev import Chebyshev
from pddecont.delay.direct import Direct
from pddecont.delay.operator import DelayMethod
from pddecont.errors import Problem, RunError
from pddecont.model.codegen import NumericModel
from pddecont.model.expression import ExpressionError, parse
from pddecont.model.system import Model
from pddecont.orbit.meshing import MeshRule
from pddecont.steps.lengths import wrong_lengths
from pddecont.steps.schema import Delay, Mesh, RunBlock, Step

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked run; ``parameters`` are the run's values, ``base`` the folder that its paths are relative to."""

    run: RunBlock
    model: Model
    numeric: NumericModel
    parameters: Array
    monitors: Mapping[str, str | float]
    warnings: tuple[Problem, ...]
    model_text: str
    run_text: str
    source: str
    base: Path

    def step_parameters(self, step: Step, start: Array | None = None) -> Array:
        """Return the parameter values of ``step``: those of the run (or ``start``), then the step's own.

        Raises
        ------
        RunError
            If a delay is negative with them, or the forcing period is no length of time.
        """
        p = (self.parameters if start is None else start).copy()
        for name, text in step.set.items():
            p[self.numeric.parameter_index(name)] = self.number(text, p)
        p = self.numeric.with_fixed(p)
        for message, _ in wrong_lengths(self.model, dict(zip(self.model.parameters, p.tolist(), strict=True))):
            raise RunError.at(self.source, 0, 0, f"step '{step.name}': {message}")
        return p

    def number(self, text: str | float, p: Array | None = None) -> float:
        """Return the number that an expression of the run file stands for at parameters ``p``."""
        values = dict(zip(self.model.parameters, self.parameters if p is None else p, strict=True))
        try:
            return self.model.evaluate(parse(text, self.model.parameter_scope("a run file")), values)
        except ExpressionError as exc:
            raise RunError.at(self.source, 0, 0, f"'{text}': {exc}") from exc

    def delay_method(self, step: Step) -> DelayMethod:
        """Return the way the delay is discretised in ``step``."""
        return delay_method(step.delay or self.run.delay)


def delay_method(spec: Delay) -> DelayMethod:
    """Return the delay method that a file asks for."""
    if spec.method == "chain":
        return Chain(spec.order or 2, spec.n or 15)
    if spec.method == "chebyshev":
        return Chebyshev(spec.n or 16)
    return Direct(spec.track_breaking_points is not False)


def mesh_rule(spec: Mesh) -> MeshRule:
    """Return the mesh rule that a file asks for."""
    return MeshRule(spec.degree, spec.intervals, None if spec.intervals is not None else spec.tol or 1e-8)


def as_number(text: str) -> str | float:
    """Return text, from the command line or a key of a file, as a number where it is one."""
    try:
        return float(text)
    except ValueError:
        return text
