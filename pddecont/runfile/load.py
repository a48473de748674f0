"""From a document to a checked run."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from pathlib import Path

from pddecont.errors import ModelError, PddecontError, RunError
from pddecont.model import MAX_BYTES, Document, KeyPath, decode, parse_document, parse_model, read_text, validate
from pddecont.runfile.find import find_file
from pddecont.runfile.kinds import StepKind
from pddecont.runfile.plan import Plan
from pddecont.runfile.planner import Overrides, RunDocument, make_plan
from pddecont.runfile.schema import make_run_types

# What every model says, and how it looks in a file that is not even YAML: without them a file is no model.
# Of the keys in a row one is enough.
MODEL_KEYS = {
    keys: re.compile(rf"""(?m)(?:^|[{{,]\s*)["']?(?:{"|".join(keys)})["']?\s*:""")
    for keys in (("states",), ("modes", "equations"))
}


def load_document(path: str) -> Document:
    """Return the YAML document at ``path`` (``-``: standard input; or the name of a shipped model or run)."""
    if path == "-":
        stream = getattr(sys.stdin, "buffer", None)
        text = (
            sys.stdin.read(MAX_BYTES + 1) if stream is None else decode(stream.read(4 * MAX_BYTES), "<stdin>", RunError)
        )
        return parse_document(text, "<stdin>", RunError)
    found = find_file(path)
    return parse_document(read_text(found, RunError), str(found), RunError)


def find_folder(document: Document) -> Path:
    """Return the folder that paths in a document are relative to; what comes from a pipe has the current one."""
    path = Path(document.path)
    return Path() if path.is_fifo() else path.parent


def is_run_file(document: Document) -> bool:
    """Whether the document describes a run (and not a model)."""
    return "states" not in document.data and ("steps" in document.data or "model" in document.data)


def load_plan(document: Document, kinds: Mapping[str, StepKind], overrides: Overrides | None = None) -> Plan:
    """Return the checked run that ``document`` describes, with steps of some ``kinds``.

    Raises
    ------
    ModelError, RunError
        With all that is wrong.
    """
    overrides = overrides or Overrides()
    folder = find_folder(document)
    block_type, file_type = make_run_types(list(kinds.values()))
    prefix: KeyPath = ()
    if is_run_file(document):
        run, problems = validate(document, file_type)
        if run is None:
            raise RunError(problems)
        model_document = _load_model_document(document, run.model, folder)
        model, warnings = parse_model(model_document)
    else:
        model, warnings = parse_model(document)
        model_document = document
        prefix = ("run",)
        if document.data.get("run") is None:
            advice = f"add a 'run' block or write a run file with 'model: {document.path}'"
            raise RunError([document.problem((), f"model '{model.name}' says nothing of a run; {advice}")])
        run, problems = validate(document, block_type, prefix)
        if run is None:
            raise RunError(problems)
    text = RunDocument(document, prefix, run, model, model_document.text, model_document.path, folder)
    return make_plan(text, kinds, overrides, warnings)


def _load_model_document(document: Document, model: str, folder: Path) -> Document:
    try:
        return _read_model(find_file(model, folder))
    except PddecontError as exc:
        if isinstance(exc, ModelError) and any(p.line for p in exc.problems):
            raise
        raise RunError([document.problem(("model",), f"the model {exc}")]) from exc


def _read_model(path: Path) -> Document:
    """Return the document of a model; of another file, which a stranger may have named, nothing is repeated."""
    text = read_text(path, ModelError)
    try:
        document = parse_document(text, str(path), ModelError)
        missing = [keys for keys in MODEL_KEYS if not document.data.keys() & set(keys)]
    except ModelError:
        missing = [keys for keys, pattern in MODEL_KEYS.items() if not pattern.search(text)]
        if not missing:
            raise
    if missing:
        listed = " and no ".join(" or ".join(f"'{key}'" for key in keys) for keys in missing)
        raise ModelError.at(str(path), 0, 0, f"is not a model file: it has no {listed} at its top")
    return document
