"""What a step of a results file must say and hold before anything is done with it; files come from strangers too."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.reasons import Reason, reason_from_json
from pddecont.results.format import Arrays, Column, StepFormat

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
# A segment that may lead to several modes, with the one that it leads to.
SEGMENT = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(>[A-Za-z_][A-Za-z0-9_]*)?\Z")
LABEL = re.compile(rb"[A-Z0-9]*\Z")
# Lists of different names in the meta data of steps; all other lists are of texts or numbers.
NAMES = (
    "parameters",
    "states",
    "monitors",
    "events",
    "segments",
    "modes",
    "signals",
    "free",
    "over",
    "quantities",
    "closed",
)
TEXTS = ("model", "settings", "mesh_settings", "curve", "curve_reason", "choice")


def check_meta(step_format: StepFormat, meta: Any) -> None:
    """Check the names and settings of a step."""
    if not isinstance(meta, dict):
        raise ResultsError("'meta' is not a mapping")
    for key in NAMES:
        names = meta.get(key, [])
        allowed = SEGMENT if key == "segments" else NAME
        are_names = isinstance(names, list) and all(isinstance(x, str) and allowed.match(x) for x in names)
        if not are_names or len(set(names)) < len(names):
            raise ResultsError(f"'{key}' is not a list of different names")
    for key, (least, most) in step_format.name_lists.items():
        if not least <= len(meta.get(key, [])) <= most:
            raise ResultsError(
                f"'{key}' holds {len(meta.get(key, []))} names; a step of this kind has {least} to {most}"
            )
    for key in TEXTS:
        if not isinstance(meta.get(key), str | None):
            raise ResultsError(f"'{key}' is not a text")
    for key in ("units", "kinds"):
        texts = meta.get(key, {})
        if not isinstance(texts, dict) or not all(isinstance(text, str) for text in texts.values()):
            raise ResultsError(f"'{key}' is not a mapping of names to texts")
    _check_settings(json.loads(meta.get("settings") or "{}"))
    for key in ("x", "y", "changes", "delayed", "asked"):
        wanted = str if key in ("delayed", "asked") else int | float
        if not isinstance(meta.get(key, []), list) or not all(isinstance(x, wanted) for x in meta.get(key, [])):
            raise ResultsError(f"'{key}' is not a list of {'texts' if wanted is str else 'numbers'}")
    if not isinstance(meta.get("ends", []), list):
        raise ResultsError("'ends' is not a list of states")
    for end in meta.get("ends", []):
        are_states = isinstance(end, list) and len(end) == len(meta.get("states") or [])
        if not are_states or not all(isinstance(x, int | float) for x in end):
            raise ResultsError("'ends' is not a list of states")
    section = meta.get("section", {})
    is_section = isinstance(section, dict) and isinstance(section.get("phase", 0), int | float)
    if meta.get("directions", 1) not in (1, 2) or not is_section:
        raise ResultsError("'directions' or 'section' is not what it should be")
    if not set(meta.get("free") or []) <= set(meta.get("parameters") or []):
        raise ResultsError("a free parameter is not among the parameters")


def _check_settings(settings: Any) -> None:
    left_out = settings.get("left_out", {}) if isinstance(settings, dict) else None
    effects = left_out.get("effects", []) if isinstance(left_out, dict) else None
    are_texts = isinstance(effects, list) and all(isinstance(x, str) for x in effects)
    if not are_texts or (left_out and not effects):
        raise ResultsError("'settings' is not a mapping, or what was left out cannot be told from it")


def check_endings(endings: Sequence[Reason]) -> None:
    """Check which directions ended."""
    if any(ending.values.get("direction", 0) not in (-1, 0, 1) for ending in endings):
        raise ResultsError("an ending is of no direction")


def check_columns(meta: Mapping[str, Any], arrays: Arrays, columns: Mapping[str, Column]) -> None:
    """Check the kinds of numbers and the shapes of all arrays that the step's format knows."""
    for name, values in arrays.items():
        column = columns.get(name)
        if column is None:
            continue
        kind = np.dtype(column.dtype).kind
        shape = column.shape(meta) if column.is_known(meta) else values.shape[1:]
        if values.dtype.kind != kind or values.shape[1:] != shape:
            raise ResultsError(
                f"'{name}' holds rows of shape {values.shape[1:]} and kind {values.dtype.kind}; "
                f"expected {shape}, {kind}"
            )


def check_contents(step_format: StepFormat, meta: Mapping[str, Any], points: Arrays, orbits: Arrays) -> None:
    """Check what arrays hold where other arrays or lists are counted by it."""
    for name, ends in orbits.items():
        if name.endswith("_end") and not _are_ends(ends):
            raise ResultsError(f"'{name}' does not say where each point's rows end")
    for names in step_format.together:
        if len({orbits[f"{name}_end"].tobytes() for name in names if f"{name}_end" in orbits}) > 1:
            raise ResultsError(f"the arrays {', '.join(names)} are not equally long")
    if "kind" in points and not all(LABEL.match(k) for k in np.unique(points["kind"])):
        raise ResultsError("a label is not made of capital letters and digits")
    _check_reasons(orbits)
    if step_format.check is not None:
        step_format.check(meta, points, orbits)


def _are_ends(values: NDArray[Any]) -> bool:
    """Return whether whole numbers, from 0 on, never fall."""
    if values.dtype.kind != "i" or values.ndim != 1:
        return False
    return not len(values) or bool(values[0] >= 0 and np.all(values[1:] >= values[:-1]))


def _check_reasons(orbits: Arrays) -> None:
    ends = orbits.get("reason_end", np.zeros(0, int))
    for i in np.flatnonzero(np.diff(ends, prepend=0)):
        try:
            reason_from_json(orbits["reason"][ends[i - 1] if i else 0 : ends[i]].tobytes().decode())
        except ValueError as exc:
            raise ResultsError(f"a reason cannot be read: {exc}") from exc
