"""What the arrays of a results file must be before anything is done with them; files come from strangers too.

An array is read only if it lies in the file itself, whole and plain, as the program writes it: no links to other files, no virtual
or external data, no filters, no room that is promised and not there. What is read is then never larger than the file.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
LABEL = re.compile(rb"[A-Z0-9]*\Z")
KINDS = ("simulate", "orbit", "continue", "sweep", "basin", "precision")
# Columns by name: kinds of numbers (f floats, i whole, S text), and what each further axis has one of: a key of meta, or a number.
COLUMNS: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "kind": ("S", ()), "note": ("S", ()), "arclength": ("f", ()), "parameters": ("f", ("parameters",)), "period": ("fi", ()),
    "stable": ("i", ()), "admissible": ("i", ()), "error_estimate": ("f", ()), "monitors": ("f", ("monitors",)), "clearance": ("f", ()),
    "n_iterations": ("i", ()), "step": ("f", ()), "n_periods": ("i", ()), "phase": ("f", ()), "n_unknowns": ("i", ()),
    "n_unstable": ("i", ()), "trivial_error": ("f", ()), "side": ("f", (2,)), "t_end": ("f", ()), "n_steps": ("i", ()),
    "n_events": ("i", ()), "turn": ("f", ()), "n_segments": ("i", ("segments",)), "lyapunov": ("f", ()), "lyapunov_error": ("f", ()),
    "chunk": ("i", ()), "cell": ("i", ()), "direction": ("i", ()), "share": ("f", ()), "line": ("i", ()),
    "family": ("S", ()), "setting": ("S", ()), "degree": ("i", ()), "intervals": ("i", ()), "tolerance": ("f", ()), "n": ("i", ()),
    "values": ("f", ("quantities",)), "errors": ("f", ("quantities",)), "error": ("f", ()), "distance": ("f", ()), "wall": ("f", ()),
    "wall_low": ("f", ()), "wall_high": ("f", ()), "cpu": ("f", ()), "memory": ("i", ()), "n_intervals": ("i", ()),
}  # fmt: skip
ARRAYS: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "time": ("f", ()), "states": ("f", ("states",)), "segment": ("i", ()), "unknowns": ("f", ()), "tangent": ("f", ()), "mesh": ("f", ()),
    "signature": ("u", ()), "multipliers": ("f", (2,)), "delayed": ("f", ("delayed",)), "mode": ("i", ()), "signals": ("f", ("signals",)),
    "event_time": ("f", ()), "event_segment": ("i", ()), "before": ("f", ("states",)), "after": ("f", ("states",)),
    "returns": ("f", ("states",)), "return_slopes": ("f", ("states",)), "return_time": ("f", ()), "memory": ("f", ()), "label": ("i", ()),
    "settling": ("f", ()),
}  # fmt: skip
# Arrays with one row each for the same thing.
TOGETHER = (
    ("time", "states", "segment", "delayed", "mode", "signals"), ("event_time", "event_segment", "before", "after"),
    ("returns", "return_slopes", "return_time"), ("label", "settling"),
)  # fmt: skip
NAMES = ("parameters", "states", "monitors", "events", "segments", "modes", "signals", "free", "over", "quantities", "closed")
# How many names a kind of step has at least and at most.
COUNTS = {"sweep": (("free", 1, 2),), "basin": (("over", 2, 2),)}


def child(group: h5py.Group, name: str, kind: type) -> Any:
    """Return a group or dataset that stands in the file itself."""
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise ResultsError(f"'{name}' is missing or leads elsewhere; only what stands in the file itself is read")
    item = group[name]
    if not isinstance(item, kind):
        raise ResultsError(f"'{name}' is not a {kind.__name__.lower()}")
    return item


def rows(group: h5py.Group, name: str, room: list[int], n: int | None = None) -> NDArray[Any]:
    """Return the first ``n`` rows of a dataset (or all); ``room`` holds the bytes that may still be read and is lessened."""
    item = _plain(group, name)
    if item.ndim < 1:
        raise ResultsError(f"'{name}' is not an array")
    n = item.shape[0] if n is None else n
    if not 0 <= n <= item.shape[0]:
        raise ResultsError(f"'{name}' has {item.shape[0]} rows; {n} are counted")
    _take(name, room, n * item.dtype.itemsize * math.prod(item.shape[1:]))
    return item[:n]


def _plain(group: h5py.Group, name: str) -> h5py.Dataset:
    """Return a dataset of numbers or texts of fixed length that is wholly there; its type and place are looked at before its contents."""
    item = child(group, name, h5py.Dataset)
    kind, plist = item.id.get_type(), item.id.get_create_plist()
    if kind.get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.STRING) or kind.detect_class(h5py.h5t.VLEN):
        raise ResultsError(f"'{name}' is not an array of numbers or text")
    if isinstance(kind, h5py.h5t.TypeStringID) and kind.is_variable_str():
        raise ResultsError(f"'{name}' is a text of variable length; only those of fixed length are read")
    if plist.get_layout() != h5py.h5d.CONTIGUOUS or plist.get_external_count() or plist.get_nfilters():
        raise ResultsError(f"'{name}' is not stored as this program stores arrays")
    if item.dtype.kind not in "fiuS" or item.dtype.itemsize * math.prod(item.shape) != item.id.get_storage_size():
        raise ResultsError(f"'{name}' is not an array of numbers or text that is wholly there")
    return item


def _take(name: str, room: list[int], size: int) -> None:
    room[0] -= size
    if room[0] < 0:
        raise ResultsError(f"'{name}' claims more than the file holds")


def text(group: h5py.Group, name: str, room: list[int]) -> str:
    """Return a text that is stored as a dataset of its own."""
    item = _plain(group, name)
    if item.shape != () or item.dtype.kind != "S":
        raise ResultsError(f"'{name}' is not a text")
    _take(name, room, item.dtype.itemsize)
    return item[()].decode()


def check_meta(kind: str, meta: Any) -> None:
    """Check the names and settings of a step."""
    if kind not in KINDS:
        raise ResultsError(f"steps of kind '{kind[:40]}' are not known (kinds: {', '.join(KINDS)})")
    if not isinstance(meta, dict):
        raise ResultsError("'meta' is not a mapping")
    for key in NAMES:
        names = meta.get(key, [])
        if not isinstance(names, list) or not all(isinstance(x, str) and NAME.match(x) for x in names) or len(set(names)) < len(names):
            raise ResultsError(f"'{key}' is not a list of different names")
    for key, least, most in COUNTS.get(kind, ()):
        if not least <= len(meta.get(key, [])) <= most:
            raise ResultsError(f"'{key}' holds {len(meta.get(key, []))} names; a step of this kind has {least} to {most}")
    for key in ("model", "settings", "mesh_settings", "curve", "choice"):
        if not isinstance(meta.get(key), str | None):
            raise ResultsError(f"'{key}' is not a text")
    units = meta.get("units", {})
    if not isinstance(units, dict) or not all(isinstance(unit, str) for unit in units.values()):
        raise ResultsError("'units' is not a mapping of names to texts")
    _check_settings(json.loads(meta.get("settings") or "{}"))
    for key in ("x", "y", "changes", "delayed"):
        wanted = str if key == "delayed" else int | float
        if not isinstance(meta.get(key, []), list) or not all(isinstance(x, wanted) for x in meta.get(key, [])):
            raise ResultsError(f"'{key}' is not a list of {'texts' if key == 'delayed' else 'numbers'}")
    for end in meta.get("ends") or []:
        if not isinstance(end, list) or len(end) != len(meta.get("states") or []) or not all(isinstance(x, int | float) for x in end):
            raise ResultsError("'ends' is not a list of states")
    if meta.get("directions", 1) not in (1, 2) or not isinstance(meta.get("section") or {}, dict):
        raise ResultsError("'directions' or 'section' is not what it should be")
    if not set(meta.get("free") or []) <= set(meta.get("parameters") or []):
        raise ResultsError("a free parameter is not among the parameters")


def _check_settings(settings: Any) -> None:
    left_out = settings.get("left_out", {}) if isinstance(settings, dict) else None
    effects = left_out.get("effects", []) if isinstance(left_out, dict) else None
    if not isinstance(effects, list) or not all(isinstance(x, str) for x in effects) or (left_out and not effects):
        raise ResultsError("'settings' is not a mapping, or what was left out cannot be told from it")


def check_columns(meta: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], known: Mapping[str, Any]) -> None:
    """Check the kinds of numbers and the shapes of all arrays that have a meaning."""
    for name, values in arrays.items():
        if name not in known:
            continue
        kinds, axes = known[name]
        shape = tuple(len(meta[axis]) if isinstance(axis, str) else axis for axis in axes if not isinstance(axis, str) or axis in meta)
        if values.dtype.kind not in kinds or (len(shape) == len(axes) and values.shape[1:] != shape):
            raise ResultsError(f"'{name}' holds rows of shape {values.shape[1:]} and kind {values.dtype.kind}; expected {shape}, {kinds}")


def check_contents(kind: str, meta: Mapping[str, Any], points: Mapping[str, NDArray[Any]], orbits: Mapping[str, NDArray[Any]]) -> None:
    """Check what arrays hold where other arrays or lists are counted by it."""
    for name, ends in orbits.items():
        if name.endswith("_end") and (ends.dtype.kind != "i" or ends.ndim != 1 or np.any(np.diff(ends, prepend=0) < 0)):
            raise ResultsError(f"'{name}' does not say where each point's rows end")
    for names in TOGETHER:
        if len({orbits[f"{name}_end"].tobytes() for name in names if f"{name}_end" in orbits}) > 1:
            raise ResultsError(f"the arrays {', '.join(names)} are not equally long")
    if "kind" in points and not all(LABEL.match(k) for k in np.unique(points["kind"])):
        raise ResultsError("a label is not made of capital letters and digits")
    if "surfaces" in points:
        shape = (len(meta.get("events", [])), len(meta.get("states", [])) + 1)
        if points["surfaces"].dtype.kind != "f" or points["surfaces"].shape[1:] != shape:
            raise ResultsError(f"'surfaces' does not hold rows of shape {shape}")
    if np.any(orbits.get("signature", np.empty(0, np.uint8)) > 127):
        raise ResultsError("a signature is not text")
    for name, listed in (("mode", "modes"), ("event_segment", "segments")):
        if name in orbits and listed in meta:
            _within(name, orbits[name], 0, len(meta[listed]))
    if kind == "simulate" and len(next(iter(points.values()), [])) > 1:
        raise ResultsError("a simulation has one row")
    if kind in ("sweep", "basin") and points.get("period", np.empty(0, int)).dtype.kind != "i":
        raise ResultsError("'period' does not count returns")
    if kind == "sweep":
        _within("direction", points.get("direction", np.zeros(0, int)), -1, 2)
    if kind == "basin" and {"line", "label"} <= {*points, *orbits}:
        columns, ends, lines = len(meta.get("x", [])), np.diff(orbits["label_end"], prepend=0), points["line"]
        _within("line", lines, -1, len(meta.get("y", [])))
        _within("label", orbits["label"], 0, int(np.sum(lines < 0)))
        if np.any(ends != np.where(lines < 0, 0, columns)) or np.any(np.diff(lines[lines >= 0], prepend=-1) != 1):
            raise ResultsError("the lines of the basin are not those of its grid")


def _within(name: str, values: NDArray[Any], low: int, high: int) -> None:
    if len(values) and not (low <= values.min() and values.max() < high):
        raise ResultsError(f"'{name}' holds numbers outside {low} to {high - 1}")
