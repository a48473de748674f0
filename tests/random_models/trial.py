"""One random model through the program, and every comparison of what it says."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pddecont.errors import PddecontError
from pddecont.results import read_results
from tests.random_models.comparison import AT_LIMIT, TOO_SENSITIVE, check_multiplier, check_period
from tests.random_models.recorded import read_orbit
from tests.random_models.sweeps import explain_attractors
from tests.runs import run

# Points at which a signature's orbit is at its own limit: the next one may be as good.
LIMITS = ("GR", "VS", "MC", "GG", "GD", "HB")
TOO_LONG = "too long"


@dataclass
class Trial:
    """What was compared for one model, and what was found.

    ``faults`` list what is wrong with no warning, each as (where, what was said, what is true); ``warned`` counts rows
    that the program itself calls no motion of the model and that are none; ``refused`` lists those that are one.
    """

    seed: int
    family: str
    outcome: str = "compared"
    why: str = ""
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


def make_run(model, *, sweep=True):
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
                "max_points": 60,
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


def try_model(model, folder, *, every=1, n_decays=3, sweep=True):
    """Return the trial of a model; of a branch every so many rows are compared."""
    trial, path = Trial(model.seed, model.family), Path(folder) / f"{model.family}_{model.seed}.h5"
    results = _run(make_run(model, sweep=sweep), trial, path)
    if results is None:
        return trial
    began = time.process_time()
    _check_rows(model, results.steps["orbit"], [0], "orbit", trial)
    _check_decay(model, results.steps["orbit"], [0], "orbit", trial)
    if "branch" in results.steps:
        branch = results.steps["branch"]
        rows = [i for n, i in enumerate(branch.order) if n % every == 0 or branch.kind_of(i)]
        _check_rows(model, branch, rows, "branch", trial)
        _check_decay(model, branch, [int(i) for i in np.linspace(0, len(branch) - 1, n_decays)], "branch", trial)
        if "sweep" in results.steps and results.steps["sweep"].done:
            counts, contradictions = explain_attractors(model, results.steps["sweep"], branch)
            trial.attractors.update(counts)
            trial.faults += contradictions
    trial.seconds["comparison"] = time.process_time() - began
    return trial


def _run(mapping, trial, path):
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


def _claims(step, row):
    """Return whether a row is said to be a motion of the model, and whether to be stable."""
    points = step.points
    admissible = bool(points["admissible"][row])
    if "verified" in points:
        admissible &= int(points["verified"][row]) != 0
    return admissible, points["stable"][row] == 1


def _check_rows(model, step, rows, where, trial):
    for row in rows:
        admissible, stable = _claims(step, row)
        orbit = read_orbit(step, row)
        verdict = check_period(model, orbit)
        trial.n_points += 1
        place = f"{where} row {row}, {model.free} = {orbit.parameters[model.free]:.8g}"
        if verdict.fault and (step.kind_of(row).startswith(LIMITS) or verdict.fault.endswith(AT_LIMIT)):
            trial.at_limit += 1
        elif verdict.fault == TOO_SENSITIVE:
            trial.too_sensitive += 1
        elif verdict.fault and not admissible:
            trial.warned += 1
        elif verdict.fault:
            said = f"admissible{', stable' if stable else ''}, [{' '.join(orbit.names)}], error {orbit.error:.1e}"
            measured = (
                "" if np.isnan(verdict.deviation) else f" by {verdict.deviation:.2e}, {verdict.allowed:.1e} allowed"
            )
            trial.faults.append((place, said, verdict.fault + measured))
        else:
            if not admissible and step.kind_of(row).startswith(LIMITS):
                trial.at_limit += 1
            elif not admissible:
                trial.refused.append((place, f"no motion of the model, [{' '.join(orbit.names)}]", "it is one"))
            trial.worst_orbit = max(trial.worst_orbit, verdict.deviation / verdict.allowed)


def _check_decay(model, step, rows, where, trial):
    for row in dict.fromkeys(rows):
        admissible, _ = _claims(step, row)
        if not admissible or step.kind_of(row).startswith(LIMITS):
            continue
        orbit, pairs = read_orbit(step, row), step.orbit(row)["multipliers"]
        found = check_multiplier(model, orbit, pairs[:, 0] + 1j * pairs[:, 1])
        if found is None:
            continue
        claimed, measured, agrees = found
        trial.n_multipliers += 1
        if agrees:
            trial.worst_multiplier = max(trial.worst_multiplier, abs(claimed - measured) / max(measured, 0.1))
        else:
            place = f"{where} row {row}, {model.free} = {orbit.parameters[model.free]:.8g}"
            trial.faults.append((place, f"leading multiplier of modulus {claimed:.6f}", f"grows by {measured:.6f}"))
