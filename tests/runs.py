"""Runs on shipped models, written in a few lines, and what tests look up in their results."""

from __future__ import annotations

from pddecont.model.document import parse_document
from pddecont.results.reader import read_results
from pddecont.steps.loading import load_plan
from pddecont.steps.run import execute
from tests.conftest import ROOT


def run(text, path, *, resume=False):
    """Execute a run file's text, as if it stood in ``configs/``, and return its results."""
    execute(load_plan(parse_document(text, str(ROOT / "configs" / "test.yaml"))), path, resume=resume, overwrite=not resume)
    return read_results(path)


def run_model(text, path):
    """Execute the run that a model's text holds itself and return its results."""
    execute(load_plan(parse_document(text, "m.yaml")), path, overwrite=True)
    return read_results(path)


def parameter(step, name, label=None):
    """Return a parameter at a labelled point, or along the branch."""
    column = step.points["parameters"][:, step.meta["parameters"].index(name)]
    return column[step.order] if label is None else column[step.row(label)]


def monitor(step, name, label=None):
    """Return a monitor at a labelled point, or along the branch."""
    column = step.points["monitors"][:, step.meta["monitors"].index(name)]
    return column[step.order] if label is None else column[step.row(label)]


def multipliers(step, row=0):
    """Return the recorded multipliers of a row."""
    pairs = step.orbit(row)["multipliers"]
    return pairs[:, 0] + 1j * pairs[:, 1]


def labels(step):
    """Return the labels along the branch, end points left out."""
    return [step.labels[i] for i in step.order if step.labels[i] and not step.labels[i].startswith("EP")]


def break_after(monkeypatch, module, number):
    """Let the work of a step's module be broken off after so many results; return what it was, to be put back."""
    whole = module.in_order

    def breaking(workers, work, chunks):
        for done, result in enumerate(whole(workers, work, chunks)):
            if done == number:
                raise KeyboardInterrupt
            yield result

    monkeypatch.setattr(module, "in_order", breaking)
    return whole
