"""One random model with delays of every kind through the program, and what a calculation apart says of its orbits."""

from __future__ import annotations

import time
from pathlib import Path

from tests.random_delays.generator import SMOOTH
from tests.random_delays.reference import check_own_past, check_smooth
from tests.random_models.program import LIMITS, begin_trial, make_run, read_claims, run_program
from tests.random_models.recorded import read_orbit

# How many error estimates an orbit may be away, and what the calculation apart may itself be off.
ESTIMATES, FLOOR = 10.0, 1e-8


def make_short_run(model, max_points=6):
    """Return a model's run: settle, solve, and follow a little way."""
    return make_run(model, max_points, sweep=False)


def try_model(model, folder, max_points=6):
    """Return the trial of a model."""
    trial, path = begin_trial(model), Path(folder) / f"{model.family}_{model.seed}.h5"
    results = run_program(make_short_run(model, max_points), trial, path)
    if results is None:
        return trial
    began = time.process_time()
    for name in ("orbit", "branch"):
        if name in results.steps:
            _check_rows(model, results.steps[name], trial)
    if results.steps["orbit"].points["stable"][0] != 1:
        trial.faults.append(("orbit", "not stable", "the motion settled there"))
    trial.seconds["comparison"] = time.process_time() - began
    return trial


def _check_rows(model, step, trial):
    for row in step.order:
        orbit = read_orbit(step, row)
        if step.kind_of(row).startswith(LIMITS):
            continue
        check = check_smooth if model.family in SMOOTH or orbit.eventless else check_own_past
        verdict = check(model, orbit)
        trial.n_points += 1
        allowed = ESTIMATES * orbit.error + FLOOR
        trial.worst_orbit = max(trial.worst_orbit, verdict.deviation / allowed)
        claimed, _ = read_claims(step, row)
        place = f"{step.name} row {row}, {model.free} = {orbit.parameters[model.free]:.8g}"
        said = f"[{' '.join(orbit.names)}], error {orbit.error:.1e}"
        wrong = verdict.fault or ("deviates" if verdict.deviation > allowed else "")
        if wrong and claimed:
            trial.faults.append((place, said, f"{wrong} by {verdict.deviation:.1e}, {allowed:.1e} allowed"))
        elif wrong:
            trial.warned += 1
        elif not claimed:
            trial.refused.append((place, f"{said}: no motion, or not verified", "it is one"))
