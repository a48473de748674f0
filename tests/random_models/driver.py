"""Many random models one after another, each within a limit of time, and what is written down of them."""

from __future__ import annotations

import json
import signal
import tempfile
from dataclasses import asdict
from pathlib import Path

from tests.random_models.program import TOO_LONG, begin_trial
from tests.runs import to_yaml

# Seconds of processor time for one model.
LIMIT = 150.0
# Faults of one model that are printed.
MOST_PRINTED = 4


class _TookTooLongError(BaseException):
    """Raised in the middle of whatever a trial does; nothing there takes it for one of its own errors."""


def try_within(try_model, model, folder, limit=LIMIT):
    """Return the trial of a model, or that it took longer than the limit."""

    def give_up(*_):
        raise _TookTooLongError

    before = signal.signal(signal.SIGPROF, give_up)
    # Where it is raised in a place that lets nothing out it is raised again.
    signal.setitimer(signal.ITIMER_PROF, limit, 1.0)
    try:
        return try_model(model, folder)
    except _TookTooLongError:
        trial = begin_trial(model)
        trial.outcome, trial.why = TOO_LONG, f"more than {limit:g} s"
        return trial
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def describe(trial):
    """Return a trial as one line."""
    kinds = f" ({', '.join(trial.kinds)})" if trial.kinds else ""
    head = f"{trial.seed} {trial.family}{kinds}: {trial.outcome}"
    if trial.outcome != "compared":
        return f"{head}: {trial.why[:300]}"
    counts = f"{trial.n_points} points, {trial.n_multipliers} multipliers"
    faults = f"{len(trial.faults)} FAULTS, {len(trial.refused)} refused" if trial.at_fault else "no fault"
    worst = f"worst {trial.worst_orbit:.2g} of what is allowed, multiplier {trial.worst_multiplier:.1e}"
    extra = [f"{k} {getattr(trial, k)}" for k in ("at_limit", "too_sensitive", "warned") if getattr(trial, k)]
    times = " ".join(f"{k} {v:.1f} s" for k, v in trial.seconds.items())
    return f"{head}, {counts}, {faults}; {', '.join([worst, *extra])}; {trial.attractors}; {times}"


def write_fault(folder, mapping, trial):
    """Write the run file of a model at fault, with what was said and what is true in its first lines."""
    lines = [
        f"# {where}\n#   said: {said}\n#   true: {true}\n" for where, said, true in [*trial.faults, *trial.refused]
    ]
    path = Path(folder) / f"{trial.family}_{trial.seed}.yaml"
    path.write_text("".join(lines) + "".join(f"# warning: {w}\n" for w in trial.warnings) + to_yaml(mapping))


def try_seeds(seeds, draw_model, make_run, try_model, folder=None):
    """Try the models of some seeds; return the trials.

    Each is printed as one line. ``folder`` gets ``trials.jsonl``, one model a line, and what is wrong as run files.
    """
    trials = []
    with tempfile.TemporaryDirectory() as scratch:
        for seed in seeds:
            model = draw_model(seed)
            trial = try_within(try_model, model, scratch)
            trials.append(trial)
            print(describe(trial), flush=True)
            for fault in trial.faults[:MOST_PRINTED]:
                print("    ", " | ".join(fault), flush=True)
            if folder is not None:
                with (Path(folder) / "trials.jsonl").open("a") as file:
                    file.write(json.dumps(asdict(trial)) + "\n")
                if trial.at_fault:
                    write_fault(folder, make_run(model), trial)
            for path in Path(scratch).iterdir():
                path.unlink()
    return trials
