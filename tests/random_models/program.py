"""A random model through the program: its run, the record of its trial, and what a row of its results claims."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, field

from pddecont.errors import PddecontError
from pddecont.results import read_results
from tests.runs import run

# Points at which a signature's orbit is at its own limit: the next one may be as good.
LIMITS = ("GR", "VS", "MC", "GG", "GD", "HB")
TOO_LONG = "too long"


@dataclass
class Trial:
    """What was compared for one model, and what was found.

    ``faults`` list what is wrong with no warning, each as (where, what was said, what is true); ``warned`` counts rows
    that the program itself calls no motion of the model and that are none; ``refused`` lists those that are one.
    ``worst_orbit`` is in parts of what is allowed.
    """

    seed: int
    family: str
    outcome: str = "compared"
    why: str = ""
    kinds: tuple[str, ...] = ()
    n_points: int = 0
    n_multipliers: int = 0
    at_limit: int = 0
    too_sensitive: int = 0
    warned: int = 0
    worst_orbit: float = 0.0
    worst_multiplier: float = 0.0
    attractors: dict[str, int] = field(default_factory=dict)
    faults: list[tuple[str, str, str]] = field(default_factory=list)
    refused: list[tuple[str, str, str]] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    @property
    def at_fault(self):
        """Whether the program said what is wrong, or called a motion none."""
        return bool(self.faults or self.refused)


def begin_trial(model):
    """Return the trial of a model of which nothing is known yet."""
    return Trial(model.seed, model.family, kinds=model.kinds)


def make_run(model, max_points=60, *, sweep=True):
    """Return a model's run: settle, solve, follow in its parameter, sweep over the same range."""
    settle = f"{model.settle}"
    steps = [
        {"name": "transient", "simulate": {"t_end": settle}},
        {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
        {
            "name": "branch",
            "continue": {
                "from": "orbit",
                "free": [model.free],
                "range": {model.free: list(model.span)},
                "stability": True,
                "max_points": max_points,
            },
        },
    ]
    low, high = model.span
    given = {"over": {model.free: [low, high, 7]}, "initial": [dict(model.initial)], "transient": settle}
    if model.section is not None:
        given["section"] = model.section
    if sweep:
        steps.append({"name": "sweep", "sweep": given})
    return {**model.as_mapping(), "run": {"steps": steps}}


def run_program(mapping, trial, path):
    """Return the results of a model's run, as far as it went; None where it gave no orbit, and the trial says why."""
    began = time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            run(mapping, path)
        except PddecontError as error:
            trial.why = " ".join(str(error).split())
    trial.seconds["program"] = time.process_time() - began
    trial.warnings = [str(w.message) for w in caught]
    results = read_results(path) if path.exists() else None
    if results is None or "orbit" not in results.steps or len(results.steps["orbit"]) == 0:
        trial.outcome = "no orbit"
        return None
    return results


def read_claims(step, row):
    """Return whether a row is said to be a motion of the model, and whether to be stable."""
    points = step.points
    admissible = bool(points["admissible"][row])
    if "verified" in points:
        admissible &= int(points["verified"][row]) != 0
    return admissible, points["stable"][row] == 1
