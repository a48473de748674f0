"""What is done to a whole results file: made, freed of spare room, brought to this format, rid of steps."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.output import explain_other
from pddecont.results.file_structure import TEXT, copy_root, copy_steps, fit_reason, make_arrays, rewrite, write_text
from pddecont.results.format import FORMAT_VERSION, N_TERMINATIONS, TEXT_BYTES
from pddecont.results.lock import check_unlocked
from pddecont.results.reader import Results, Step, is_results_file, read_results


def create_results(
    path: Path, model_text: str, run_text: str, source: str, versions: str, *, overwrite: bool = False
) -> None:
    """Make a new results file.

    An existing one is refused unless ``overwrite``; a file of another kind always is.
    """
    if path.exists():
        if not overwrite:
            raise ResultsError(
                f"{path} exists already; give --resume to go on with it, --overwrite to replace it, or another -o"
            )
        check_unlocked(path)
        if path.stat().st_size and not is_results_file(path):
            raise explain_other(path, "a results file")

    def fill(_: h5py.File | None, new: h5py.File) -> None:
        new.attrs["format_version"] = FORMAT_VERSION
        for name, text in (("versions", versions), ("source", source), ("model", model_text), ("run", run_text)):
            write_text(new, name, text)
        new.create_group("steps", track_order=True)

    rewrite(path, fill, fresh=True)


def compact_step(path: Path, name: str) -> Step:
    """Take the spare room out of a step's arrays; return the step.

    Where the step is a branch that is done, write its table of special points.
    """
    step = read_results(path, name).step(name)
    return step if step.compact else write_compact(path, step)


def write_compact(path: Path, step: Step) -> Step:
    """Write a step, which the file holds, without spare room; return it."""

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        had, target = old[f"steps/{step.name}"], copy_steps(old, new, anew=step.name)
        for key in ("kind", "meta", "finished", "termination"):
            old.copy(had[key], target)
        make_arrays(target, _list_arrays(step))

    rewrite(path, change)
    return replace(step, compact=True)


def _list_arrays(step: Step) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the columns of a step as its file is to hold them, and for a branch that is done its special points."""
    for group, arrays, columns in (
        ("points", step.points, step.format.points),
        ("orbits", step.orbits, step.format.orbits),
    ):
        for name, values in arrays.items():
            yield f"{group}/{name}", values.astype(columns[name].dtype, copy=False) if name in columns else values
    if step.done and step.format.has_branch:
        special = [(label.encode(), i) for i, label in enumerate(step.labels) if label]
        yield "special_points/label", np.array([label for label, _ in special], dtype="S8")
        yield "special_points/index", np.array([i for _, i in special], dtype="i8")


def upgrade_results(results: Results) -> None:
    """Write a file of an older format, as it was read, as this one's, so that it can be continued."""
    if results.version == FORMAT_VERSION:
        return

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        steps = copy_root(old, new)
        for name, step in results.steps.items():
            target = steps.create_group(name)
            for key in ("kind", "meta"):
                old.copy(f"steps/{name}/{key}", target, name=key)
            endings = np.zeros(N_TERMINATIONS, dtype=TEXT.dtype)
            endings[: len(step.endings)] = [fit_reason(ending, TEXT_BYTES).encode() for ending in step.endings]
            counts = [("finished", np.array([len(step)])), ("termination", endings)]
            make_arrays(target, itertools.chain(counts, _list_arrays(step)))

    rewrite(results.path, change)


def drop_steps(path: Path, names: Sequence[str]) -> None:
    """Remove steps, finished or not, so that they can be computed anew."""

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        steps = copy_steps(old, new)
        for name in names:
            if name in steps:
                del steps[name]

    rewrite(path, change)
