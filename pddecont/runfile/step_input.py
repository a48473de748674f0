"""What a kind of step is given to resolve what a file says of one step."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Generic, TypeVar

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.errors import RunError
from pddecont.model import Model, Scope
from pddecont.orbit import Monitor
from pddecont.runfile.checker import Checker, Path
from pddecont.runfile.data_file import read_data_file
from pddecont.runfile.fields import Delay, Source
from pddecont.runfile.formula import ParameterFormula
from pddecont.runfile.holding import Holding

F = TypeVar("F")


@dataclass(frozen=True, eq=False)
class StepInput(Generic[F]):
    """One step of a file on its way into the plan; what it notes as wrong is at places below ``path``.

    Attributes
    ----------
    body
        What the file says under the kind's name.
    values
        Parameters by name: the run's, then the step's own, as far as they do not come from where it starts.
    delay
        How delayed values are found.
    monitors
        The run's monitors by name.
    has_own_parameters
        Whether the step sets parameters itself.
    source
        Where the step starts.
    source_kind, source_holds
        The kind of the step above that is meant, by name, and what it leaves, if it is one of this run.
    known
        Parameters by name that the step is sure to start with, whatever is computed above it.
    folder
        What paths are relative to.
    files
        Fingerprints of the files of data that the step has read, by their names in the file.
    """

    checker: Checker
    path: Path
    name: str
    body: F
    numeric: NumericModel
    values: Mapping[str, float]
    delay: Delay
    monitors: Mapping[str, Monitor]
    has_own_parameters: bool = False
    source: Source | None = None
    source_kind: str = ""
    source_holds: Holding | None = None
    known: Mapping[str, float] = field(default_factory=dict)
    folder: FilePath = FilePath()
    files: dict[str, str] = field(default_factory=dict)

    @property
    def model(self) -> Model:
        """The model, without the effects that the run leaves out."""
        return self.checker.model

    @property
    def parameters(self) -> NDArray[np.float64]:
        """Parameters, shape (n_parameters,)."""
        return self.numeric.with_fixed(np.array([self.values[name] for name in self.model.parameters], dtype=float))

    def add_error(self, path: Path, message: str, *, offset: int = 0, key: bool = False) -> None:
        """Note that something is wrong at a place below the kind's name."""
        self.checker.add_error((*self.path, *path), message, offset=offset, key=key)

    def add_warning(self, path: Path, message: str) -> None:
        """Note that something is suspicious at a place below the kind's name."""
        self.checker.add_warning((*self.path, *path), message)

    def parse(self, path: Path, text: str | float, scope: Scope) -> sympy.Expr:
        """Return the expression that ``text`` writes."""
        return self.checker.parse((*self.path, *path), text, scope)

    def parse_formula(self, path: Path, text: str | float) -> ParameterFormula:
        """Return the number that ``text`` writes as an expression in the parameters."""
        return self.checker.parse_formula((*self.path, *path), text)

    def evaluate(self, path: Path, text: str | float, values: Mapping[str, float] | None = None) -> float:
        """Return the number that ``text`` stands for, at the step's parameters or other ``values``."""
        return self.checker.evaluate((*self.path, *path), text, self.values if values is None else values)

    def check_settable(self, path: Path, name: str, *, key: bool = True) -> bool:
        """Return whether a name is a parameter that can be given a value; note a problem where it is none."""
        return self.checker.check_settable((*self.path, *path), name, key=key)

    def check_durations(self, path: Path, values: Mapping[str, float]) -> None:
        """Check that delays and the forcing period are lengths of time at some parameters."""
        self.checker.check_durations((*self.path, *path), values)

    def read_file(self, path: Path, name: str) -> str | None:
        """Return the text of a file of data, relative to the run file; None, and a problem noted, if it has none."""
        try:
            text = read_data_file(self.folder / name)
        except RunError as exc:
            self.add_error(path, str(exc))
            return None
        self.files[name] = hashlib.sha256(text.encode()).hexdigest()
        return text
