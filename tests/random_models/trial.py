"""One random model through the program, and every comparison of what it says."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from tests.random_models.comparison import AT_LIMIT, TOO_SENSITIVE, check_multiplier, check_period
from tests.random_models.program import LIMITS, begin_trial, make_run, read_claims, run_program
from tests.random_models.recorded import read_orbit
from tests.random_models.sweeps import explain_attractors


def try_model(model, folder, *, every=1, n_decays=3, sweep=True):
    """Return the trial of a model; of a branch every so many rows are compared."""
    trial, path = begin_trial(model), Path(folder) / f"{model.family}_{model.seed}.h5"
    results = run_program(make_run(model, sweep=sweep), trial, path)
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


def _check_rows(model, step, rows, where, trial):
    for row in rows:
        admissible, stable = read_claims(step, row)
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
        admissible, _ = read_claims(step, row)
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
