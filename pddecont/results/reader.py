"""Reading results files, finished or not."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError, suggest
from pddecont.memo import cached_property
from pddecont.reasons import NO_REASON, Reason, reason_from_json
from pddecont.results.checks import NAME, check_columns, check_contents, check_endings, check_meta
from pddecont.results.format import FORMAT_VERSION, N_TERMINATIONS, OLDEST_VERSION, StepFormat
from pddecont.results.step_formats import find_format
from pddecont.results.stored_arrays import list_names, open_array, open_group
from pddecont.results.upgrade import add_columns, upgrade_step


class Fields(dict[str, Any]):
    """What a step holds by name; a name that is missing is the file's fault."""

    def __init__(self, step: str, values: Mapping[str, Any]):
        super().__init__(values)
        self.step = step

    def __missing__(self, name: str) -> Any:
        raise ResultsError(f"step '{self.step}' has no '{name}'; the file is damaged, or was not made by this program")


@dataclass(frozen=True, eq=False)
class Step:
    """One step of a results file.

    ``points`` holds arrays with one row a point; ``orbit(i)`` the rows of point ``i``. ``done``: all of it was
    computed; ``compact``: its arrays have no spare room, and a branch has its table of special points.
    """

    name: str
    kind: str
    meta: Mapping[str, Any]
    points: Mapping[str, NDArray[Any]]
    orbits: Mapping[str, NDArray[Any]]
    endings: tuple[Reason, ...]
    done: bool
    compact: bool = True

    def __len__(self) -> int:
        return len(next(iter(self.points.values()))) if self.points else 0

    def orbit(self, i: int) -> dict[str, NDArray[Any]]:
        """Return the rows that belong to point ``i``."""
        result = Fields(self.name, {})
        for name, values in self.orbits.items():
            if not name.endswith("_end"):
                ends = self.orbits[f"{name}_end"]
                result[name] = values[ends[i - 1] if i else 0 : ends[i]]
        return result

    @property
    def format(self) -> StepFormat:
        """What this kind of step keeps."""
        return find_format(self.kind)

    def kind_of(self, i: int) -> str:
        """Return the kind of point ``i``, as labels begin with it; empty for an ordinary one."""
        return str(self.points["kind"][i].decode()) if "kind" in self.points else ""

    def reason(self, i: int) -> Reason:
        """Return what was recorded of why point ``i`` is special, or failed."""
        if "reason" not in self.orbits:
            return NO_REASON
        ends = self.orbits["reason_end"]
        return reason_from_json(self.orbits["reason"][ends[i - 1] if i else 0 : ends[i]].tobytes().decode())

    @property
    def curve_reason(self) -> Reason:
        """What was recorded of the special point that a curve in two parameters follows."""
        return reason_from_json(self.meta.get("curve_reason") or "")

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
                kind = self.kind_of(i)
                if kind:
                    counts[kind] = counts.get(kind, 0) + 1
                    labels[i] = f"{kind}{'_' if kind[-1].isdigit() else ''}{counts[kind]}"
        return tuple(labels)

    def row(self, label: str) -> int:
        """Return the row of a label, or raise :class:`ResultsError` with those there are."""
        if label in self.labels:
            return self.labels.index(label)
        known = [x for x in self.labels if x]
        raise ResultsError(
            f"step '{self.name}' has no point '{label}'{suggest(str(label), known)} (labels: "
            f"{', '.join(known) or 'none'})"
        )


@dataclass(frozen=True, eq=False)
class Results:
    """The contents of a results file; ``names`` lists all its steps, of which ``steps`` holds those that were read.

    ``version`` is that of its format.
    """

    path: Path
    version: int
    versions: Mapping[str, str]
    source: str
    model_text: str
    run_text: str
    names: tuple[str, ...]
    steps: Mapping[str, Step]

    def step(self, name: str) -> Step:
        """Return a step by name, or raise :class:`ResultsError` with those there are."""
        if name not in self.steps:
            raise ResultsError(
                f"{self.path} has no step '{name}'{suggest(str(name), self.names)} "
                f"(steps: {', '.join(self.names) or 'none'})"
            )
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
        raise ResultsError(
            f"{path} cannot be read as a results file: it is not HDF5; results files are made with 'pddecont run'"
        )
    try:
        with h5py.File(path, "r") as file:
            return _read(path, file, only)
    except BlockingIOError as exc:
        raise ResultsError(f"{path} is locked by another program that writes to it; close it there") from exc
    except ResultsError as exc:
        raise ResultsError(f"{path}: {exc}") from exc
    except (OSError, KeyError, ValueError, TypeError, AttributeError, OverflowError, RuntimeError, MemoryError) as exc:
        # h5py raises all of these for files that are damaged in one place or another.
        reason = "it is shorter than it says" if "truncated file" in str(exc) else " ".join(str(exc).split())[:200]
        raise ResultsError(
            f"{path} cannot be read as a results file: {reason}; the file is damaged or of another kind"
        ) from exc


def is_results_file(path: Path) -> bool:
    """Whether the file at ``path`` was made by this program, in whichever version."""
    if not h5py.is_hdf5(path):
        return False
    try:
        with h5py.File(path, "r") as file:
            return _format_version(file) > 0 and {"model", "run", "steps"} <= set(file)
    except (OSError, ResultsError, RuntimeError, ValueError, KeyError):
        # h5py raises these for files that are damaged.
        return False


def _read(path: Path, file: h5py.File, only: str | None) -> Results:
    version = _format_version(file)
    if version > FORMAT_VERSION:
        raise ResultsError(f"its format version is {version}, newer than {FORMAT_VERSION}; install a newer pddecont")
    if version < OLDEST_VERSION:
        raise ResultsError(f"its format version is {version}, older than {OLDEST_VERSION}; compute it again")
    room, root = [path.stat().st_size], h5py.h5g.open(file.id, b"/")
    versions = json.loads(open_array(root, "versions").read_text(room))
    if not isinstance(versions, dict) or not all(isinstance(v, str) for v in versions.values()):
        raise ResultsError("'versions' is not a mapping of names to versions")
    group = open_group(root, "steps")
    steps, names = {}, list_names(group)
    for name in names:
        if not NAME.match(name):
            raise ResultsError("a step's name is not a name")
        if only not in (None, name):
            continue
        try:
            steps[name] = _read_step(name, open_group(group, name), room, version)
        except ResultsError as exc:
            raise ResultsError(f"step '{name}': {exc}; the file is damaged or of another kind") from exc
    source, model_text, run_text = (open_array(root, name).read_text(room) for name in ("source", "model", "run"))
    return Results(path, version, versions, source, model_text, run_text, tuple(names), steps)


def _format_version(file: h5py.File) -> int:
    """Return the format's version; its type is looked at before it is read."""
    if "format_version" not in file.attrs:
        raise ResultsError("this is an HDF5 file but not a results file of pddecont")
    item = h5py.h5a.open(file.id, b"format_version")
    if item.get_type().get_class() != h5py.h5t.INTEGER or item.shape != ():
        raise ResultsError("its format version is not a number")
    return int(file.attrs["format_version"])


def _read_step(name: str, group: h5py.h5g.GroupID, room: list[int], version: int) -> Step:
    kind, meta = open_array(group, "kind").read_text(room), json.loads(open_array(group, "meta").read_text(room))
    step_format, names = find_format(kind), list_names(group)
    check_meta(step_format, meta)
    n = int(open_array(group, "finished").read(room, 1)[0])
    points, are_full = _read_points(open_group(group, "points"), room, n)
    orbits, orbits_are_full = _read_orbits(open_group(group, "orbits"), room, n) if "orbits" in names else ({}, True)
    lines = [line for line in open_array(group, "termination").read(room, N_TERMINATIONS) if line]
    if version == OLDEST_VERSION:
        points, orbits, endings = upgrade_step(kind, meta, points, orbits, lines)
    else:
        endings = tuple(reason_from_json(line.decode()) for line in lines)
        points, orbits = add_columns(kind, points, orbits) if version < FORMAT_VERSION else (points, orbits)
    check_endings(endings)
    check_columns(meta, points, step_format.points)
    check_columns(meta, orbits, step_format.orbits)
    check_contents(step_format, meta, points, orbits)
    compact = are_full and orbits_are_full and (not step_format.has_branch or "special_points" in names)
    return make_step(name, kind, meta, points, orbits, endings, compact=compact)


def make_step(
    name: str,
    kind: str,
    meta: dict[str, Any],
    points: dict[str, NDArray[Any]],
    orbits: dict[str, NDArray[Any]],
    endings: tuple[Reason, ...],
    *,
    compact: bool = False,
) -> Step:
    """Return a step; it is done when all its directions have ended."""
    held = [Fields(name, values) for values in (meta, points, orbits)]
    return Step(name, kind, held[0], held[1], held[2], endings, len(endings) >= meta.get("directions", 1), compact)


def _read_points(group: h5py.h5g.GroupID, room: list[int], n: int) -> tuple[dict[str, NDArray[Any]], bool]:
    """Return the columns of ``n`` points, and whether they have no room for more."""
    arrays = [open_array(group, key) for key in list_names(group)]
    return {array.name: array.read(room, n) for array in arrays}, all(len(array) == n for array in arrays)


def _read_orbits(group: h5py.h5g.GroupID, room: list[int], n: int) -> tuple[dict[str, NDArray[Any]], bool]:
    """Return the rows of ``n`` points and where each point's end, and whether there is no room for more."""
    held: dict[str, NDArray[Any]] = {}
    is_full = True
    for key in list_names(group):
        if key.endswith("_end"):
            ends, rows = open_array(group, key), open_array(group, key[:-4])
            held[key] = ends.read(room, n)
            held[rows.name] = rows.read(room, int(held[key][-1]) if n else 0)
            is_full = is_full and len(ends) == n and len(rows) == len(held[rows.name])
    return held, is_full
