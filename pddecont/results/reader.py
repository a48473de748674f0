"""Reading results files, finished or not."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError, suggest
from pddecont.results.layout import FORMAT_VERSION


@dataclass(frozen=True, eq=False)
class Step:
    """One step of a results file.

    ``points`` holds arrays with one row a point; ``orbit(i)`` the rows of point ``i``.
    """

    name: str
    kind: str
    meta: Mapping[str, Any]
    points: Mapping[str, NDArray[Any]]
    orbits: Mapping[str, NDArray[Any]]
    termination: tuple[str, ...]
    done: bool

    def __len__(self) -> int:
        return len(next(iter(self.points.values()))) if self.points else 0

    def orbit(self, i: int) -> dict[str, NDArray[Any]]:
        """Return the rows that belong to point ``i``."""
        result = {}
        for name, rows in self.orbits.items():
            if not name.endswith("_end"):
                ends = self.orbits[f"{name}_end"]
                result[name] = rows[ends[i - 1] if i else 0 : ends[i]]
        return result

    @cached_property
    def order(self) -> NDArray[np.intp]:
        """Row numbers in order along the branch."""
        if "arclength" not in self.points:
            return np.arange(len(self))
        return np.argsort(self.points["arclength"], kind="stable")

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Label of each row: kind and number along the branch (``GR1``, ``R4_1``); empty for ordinary points."""
        labels = [""] * len(self)
        if "kind" in self.points:
            counts: dict[str, int] = {}
            for i in self.order:
                kind = self.points["kind"][i].decode()
                if kind:
                    counts[kind] = counts.get(kind, 0) + 1
                    labels[i] = f"{kind}{'_' if kind[-1].isdigit() else ''}{counts[kind]}"
        return tuple(labels)

    def row(self, label: str) -> int:
        """Return the row of a label, or raise :class:`ResultsError` with those there are."""
        if label in self.labels:
            return self.labels.index(label)
        known = [x for x in self.labels if x]
        raise ResultsError(f"step '{self.name}' has no point '{label}'{suggest(label, known)} (labels: {', '.join(known) or 'none'})")


@dataclass(frozen=True, eq=False)
class Results:
    """The contents of a results file; ``names`` lists all its steps, of which ``steps`` holds those that were read."""

    path: Path
    versions: Mapping[str, str]
    source: str
    model_text: str
    run_text: str
    names: tuple[str, ...]
    steps: Mapping[str, Step]

    def step(self, name: str) -> Step:
        """Return a step by name, or raise :class:`ResultsError` with those there are."""
        if name not in self.steps:
            raise ResultsError(f"{self.path} has no step '{name}'{suggest(name, self.names)} (steps: {', '.join(self.names) or 'none'})")
        return self.steps[name]


def read_results(path: str | Path, only: str | None = None) -> Results:
    """Return what a results file holds, of its steps all or ``only`` one.

    Raises
    ------
    ResultsError
        If it is not a file that this version can read.
    """
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path} does not exist; make it with 'pddecont run'")
    if not h5py.is_hdf5(path):
        raise ResultsError(f"{path} cannot be read as a results file: it is not HDF5; results files are made with 'pddecont run'")
    try:
        with h5py.File(path, "r") as file:
            version = file.attrs.get("format_version")
            if version is None:
                raise ResultsError(f"{path} is an HDF5 file but not a results file of pddecont")
            if int(version) > FORMAT_VERSION:
                raise ResultsError(f"{path} has format version {version}, newer than {FORMAT_VERSION}; install a newer pddecont")
            steps = {name: _read_step(name, file["steps"][name]) for name in file["steps"] if only in (None, name)}
            return Results(path, json.loads(file.attrs["versions"]), str(file.attrs["source"]), file["model"].asstr()[()],
                           file["run"].asstr()[()], tuple(file["steps"]), steps)  # fmt: skip
    except (OSError, KeyError, ValueError, TypeError, AttributeError) as exc:
        raise ResultsError(f"{path} cannot be read as a results file: {exc}") from exc


def _read_step(name: str, group: h5py.Group) -> Step:
    n = int(group["finished"][0])
    points = {key: item[:n] for key, item in group["points"].items()}
    orbits = {}
    for key, item in group.get("orbits", {}).items():
        if key.endswith("_end"):
            orbits[key] = item[:n]
            total = int(orbits[key][-1]) if n else 0
            orbits[key[:-4]] = group["orbits"][key[:-4]][:total]
    texts = tuple(text.decode(errors="replace") for text in group["termination"][:] if text)
    meta = json.loads(group.attrs["meta"])
    return Step(name, str(group.attrs["kind"]), meta, points, orbits, texts, len(texts) >= meta.get("directions", 1))
