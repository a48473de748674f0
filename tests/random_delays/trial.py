"""One random model with delays of every kind through the program, and what a calculation apart says of its orbits."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, field
from pathlib import Path

from pddecont.errors import PddecontError
from pddecont.results import read_results
from tests.random_delays.generator import SMOOTH
from tests.random_delays.reference import check_own_past, check_smooth
from tests.random_models.recorded import read_orbit
from tests.random_models.trial import LIMITS
from tests.runs import run

# How many error estimates an orbit may be away, and what the calculation apart may itself be off.
ESTIMATES, FLOOR = 10.0, 1e-8


@dataclass
class Trial:
    """What was compared for one model; ``faults`` are (where, what was said, what is true)."""

    seed: int
    family: str
    kinds: tuple[str, ...]
    outcome: str = "compared"
    why: str = ""
    n_points: int = 0
    worst: float = 0.0
    faults: list[tuple[str, str, str]] = field(default_factory=list)
    unverified: int = 0
    warnings: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)


def make_run(model, max_points=6):
    """Return a model's run: settle, solve, and follow a little way."""
    follow = {"from": "orbit", "free": [model.free], "range": {model.free: list(model.span)}, "stability": True}
    steps = [
        {"name": "transient", "simulate": {"t_end": model.settle}},
        {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
        {"name": "branch", "continue": {**follow, "max_points": max_points}},
    ]
    return {**model.as_mapping(), "run": {"steps": steps}}


def try_model(drawn, folder, max_points=6):
    """Return the trial of a model."""
    model = drawn.model
    trial = Trial(model.seed, model.family, drawn.kinds)
    path = Path(folder) / f"{model.family}_{model.seed}.h5"
    began = time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            run(make_run(model, max_points), path)
        except PddecontError as error:
            trial.why = " ".join(str(error).split())
    trial.seconds["program"] = time.process_time() - began
    trial.warnings = [str(w.message) for w in caught]
    results = read_results(path) if path.exists() else None
    if results is None or "orbit" not in results.steps or len(results.steps["orbit"]) == 0:
        trial.outcome = "no orbit"
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
        trial.worst = max(trial.worst, verdict.deviation / allowed)
        admissible = bool(step.points["admissible"][row])
        verified = "verified" not in step.points or int(step.points["verified"][row]) != 0
        place = f"{step.name} row {row}, {model.free} = {orbit.parameters[model.free]:.8g}"
        said = f"[{' '.join(orbit.names)}], error {orbit.error:.1e}"
        wrong = verdict.fault or ("deviates" if verdict.deviation > allowed else "")
        if wrong and admissible and verified:
            trial.faults.append((place, said, f"{wrong} by {verdict.deviation:.1e}, {allowed:.1e} allowed"))
        elif not wrong and not (admissible and verified):
            trial.faults.append((place, f"{said}: no motion, or not verified", "it is one"))
        trial.unverified += bool(wrong and not (admissible and verified))
