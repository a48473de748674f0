"""What is done to a whole results file: made, freed of spare room, brought to this format, rid of steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from pddecont.errors import ResultsError
from pddecont.output import explain_other
from pddecont.results.file_structure import TEXT, copy_root, copy_steps, fit_reason, make_array, rewrite, write_text
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
    if step.compact:
        return step

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        had, target = old[f"steps/{name}"], copy_steps(old, new, anew=name)
        for key in ("kind", "meta"):
            old.copy(had[key], target)
        lengths = {"finished": 1, "termination": N_TERMINATIONS} | {
            f"points/{key}": len(rows) for key, rows in step.points.items()
        }
        lengths |= {f"orbits/{key}": len(rows) for key, rows in step.orbits.items()}
        for key, n in lengths.items():
            make_array(target, had, key, had[key].dtype.str, had[key].shape[1:], n, n)
        _write_special_points(target, step)

    rewrite(path, change)
    return replace(step, compact=True)


def _write_special_points(target: h5py.Group, step: Step) -> None:
    """Write the table of special points of a branch that is done."""
    if step.done and step.format.has_branch:
        special = [(label, i) for i, label in enumerate(step.labels) if label]
        group = target.create_group("special_points")
        group["label"] = np.array([label.encode() for label, _ in special], dtype="S8")
        group["index"] = np.array([i for _, i in special], dtype="i8")


def upgrade_results(results: Results) -> None:
    """Write a file of an older format, as it was read, as this one's, so that it can be continued."""
    if results.version == FORMAT_VERSION:
        return

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        steps = copy_root(old, new)
        for name, step in results.steps.items():
            target, n = steps.create_group(name), len(step)
            for key in ("kind", "meta"):
                old.copy(f"steps/{name}/{key}", target, name=key)
            endings = np.zeros(N_TERMINATIONS, dtype=TEXT.dtype)
            endings[: len(step.endings)] = [fit_reason(ending, TEXT_BYTES).encode() for ending in step.endings]
            arrays = {"finished": np.array([n]), "termination": endings}
            arrays |= {f"points/{key}": values for key, values in step.points.items()}
            arrays |= {f"orbits/{key}": values for key, values in step.orbits.items()}
            columns = {f"points/{key}": column for key, column in step.format.points.items()}
            columns |= {f"orbits/{key}": column for key, column in step.format.orbits.items()}
            for key, values in arrays.items():
                dtype = columns[key].dtype if key in columns else values.dtype.str
                make_array(target, arrays, key, dtype, values.shape[1:], len(values), len(values))
            _write_special_points(target, step)

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
