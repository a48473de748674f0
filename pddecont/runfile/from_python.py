"""A run given in Python, by path, text or mappings, written as the YAML that a person would have written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pddecont.errors import RunError
from pddecont.model import Document, parse_document
from pddecont.runfile.find import find_file, name_file
from pddecont.runfile.load import find_folder, is_run_file, load_document

SOURCE = "<python>"


def write_run(
    model: str | Path | Mapping[str, Any], steps: Sequence[Mapping[str, Any]] | None, keys: Mapping[str, Any]
) -> Document:
    """Return the document of a run on ``model`` with ``steps`` and other ``keys`` of a run file in place of its own.

    ``model`` is a path or the name of a shipped file, text with more than one line, or a mapping.
    """
    document = _document(model)
    changes = {**keys, **({} if steps is None else {"steps": list(steps)})}
    if not changes:
        return document
    data = document.data
    if is_run_file(document):
        folder = find_folder(document)
        merged = {**data, **changes}
        # Text from here has no folder of its own, so that a model that is not shipped is named in full.
        if isinstance(data.get("model"), str):
            merged["model"] = name_file(find_file(data["model"], folder))
        return _parse(merged, str(folder / SOURCE))
    block = data.get("run") or {}
    merged = {**(block if isinstance(block, dict) else {}), **changes}
    if isinstance(model, Mapping) or _is_text(model) or not Path(document.path).is_file():
        return _parse({**data, "run": merged}, SOURCE)
    # A model in a file stays there: what is wrong in it is reported at its own lines.
    return _parse({"model": name_file(Path(document.path)), **merged}, str(find_folder(document) / SOURCE))


def _document(model: str | Path | Mapping[str, Any]) -> Document:
    if isinstance(model, Mapping):
        return _parse(model, SOURCE)
    return parse_document(str(model), SOURCE, RunError) if _is_text(model) else load_document(str(model))


def _is_text(model: object) -> bool:
    return isinstance(model, str) and "\n" in model


def _parse(data: Mapping[str, Any], path: str) -> Document:
    text = yaml.safe_dump(_plain(data), sort_keys=False, allow_unicode=True, width=1000)
    return replace(parse_document(text, path, RunError), is_written=True)


def _plain(value: Any) -> Any:
    """Return a value as YAML can write it: arrays and tuples as lists, numbers of NumPy as Python's."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, str | bool | int | float) or value is None:
        return value
    raise RunError.at(
        SOURCE, 0, 0, f"{value!r} cannot be written in a run; expected text, a number, a list or a mapping"
    )
