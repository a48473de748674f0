"""Runs written as mappings, and what tests look up in their results."""

from __future__ import annotations

import yaml

from pddecont.results import read_results
from pddecont.runfile import write_run
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute


def plan(run):
    """Return the plan of a run: a mapping with a run file's keys (or a model's, with a ``run`` block), or text."""
    return load_run_plan(write_run(run, None, {}))


def run(run, path, *, resume=False):
    """Execute a run and return its results; shipped models are meant by their names."""
    execute(plan(run), path, resume=resume, overwrite=not resume)
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
    whole = module.map_in_order

    def breaking(workers, work, chunks):
        for done, result in enumerate(whole(workers, work, chunks)):
            if done == number:
                raise KeyboardInterrupt
            yield result

    monkeypatch.setattr(module, "map_in_order", breaking)
    return whole


def to_yaml(data):
    """Return a run or a model as the text of its file."""
    return yaml.safe_dump(data, sort_keys=False, width=1000)


def change(data, path, value):
    """Return a copy of a run or a model with another value at a place such as ``run.steps.1.orbit.from``."""
    first, _, rest = path.partition(".")
    key = int(first) if isinstance(data, list) else first
    result = list(data) if isinstance(data, list) else dict(data)
    result[key] = change(data[key], rest, value) if rest else value
    return result


def add_step(data, step):
    """Return a copy of a run, or of a model with a run, with one step more."""
    if "run" in data:
        return {**data, "run": add_step(data["run"], step)}
    return {**data, "steps": [*data["steps"], step]}
