"""From a document to a checked run."""

from __future__ import annotations

import sys
from pathlib import Path

from pddecont.errors import ModelError, PddecontError, RunError
from pddecont.model.builder import parse_model
from pddecont.model.document import MAX_BYTES, Document, KeyPath, decoded, parse_document, read_text
from pddecont.model.validation import validate
from pddecont.shipped.find import find
from pddecont.steps.plan import Plan
from pddecont.steps.planner import Overrides, Planner
from pddecont.steps.schema import RunBlock, RunFile


def load_document(path: str) -> Document:
    """Return the YAML document at ``path`` (``-``: standard input; or the name of a shipped model or run)."""
    if path == "-":
        stream = getattr(sys.stdin, "buffer", None)
        text = sys.stdin.read(MAX_BYTES + 1) if stream is None else decoded(stream.read(4 * MAX_BYTES), "<stdin>", RunError)
        return parse_document(text, "<stdin>", RunError)
    found = find(path)
    return parse_document(read_text(found, RunError), str(found), RunError)


def is_run_file(document: Document) -> bool:
    """Whether the document describes a run (and not a model)."""
    return "states" not in document.data and ("steps" in document.data or "model" in document.data)


def load_plan(document: Document, overrides: Overrides | None = None) -> Plan:
    """Return the checked run that ``document`` describes; raise ModelError or RunError with all that is wrong."""
    overrides = overrides or Overrides()
    folder = Path(document.path).parent
    if is_run_file(document):
        run, problems = validate(document, RunFile)
        if run is None:
            raise RunError(problems)
        try:
            model_path = find(run.model, folder)
            model_document = parse_document(read_text(model_path, ModelError), str(model_path), ModelError)
        except PddecontError as exc:
            if isinstance(exc, ModelError) and any(p.line for p in exc.problems):
                raise
            raise RunError([document.problem(("model",), f"the model {exc}")]) from exc
        model, warnings = parse_model(model_document)
        prefix: KeyPath = ()
    else:
        model, warnings = parse_model(document)
        model_document = document
        prefix = ("run",)
        if document.data.get("run") is None:
            raise RunError([document.problem((), f"model '{model.name}' says nothing of a run; add a 'run' block or write a run file "
                                                 f"with 'model: {document.path}'")])  # fmt: skip
        run, problems = validate(document, RunBlock, prefix)
        if run is None:
            raise RunError(problems)
    return Planner(document, prefix, run, model, overrides).plan(warnings, model_document.text, folder)
