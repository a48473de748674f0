"""Random models by the number: ``python -m tests.random_models FIRST NUMBER [FOLDER]``.

Each model is one line; tables of all follow. FOLDER gets ``trials.jsonl``, one model a line, and what is wrong as run
files that show it, with what was said and what is true. Models of different seeds may be tried side by side. One that
takes longer than LIMIT is given up, and counted.
"""

from __future__ import annotations

import json
import signal
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

from tests.random_models.generator import draw_model
from tests.random_models.trial import TOO_LONG, Trial, make_run, try_model
from tests.reliability import RANDOM, page
from tests.runs import to_yaml

# Seconds of processor time for one model.
LIMIT = 150.0


class _TookTooLongError(BaseException):
    """Raised in the middle of whatever a trial does; nothing there takes it for one of its own errors."""


def try_within(model, folder, limit=LIMIT):
    """Return the trial of a model, or that it took longer than the limit."""

    def give_up(*_):
        raise _TookTooLongError

    before = signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        return try_model(model, folder)
    except _TookTooLongError:
        return Trial(model.seed, model.family, TOO_LONG, f"more than {limit:g} s")
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def describe(trial):
    """Return a trial as one line."""
    counts = f"{trial.n_points} points, {trial.n_multipliers} multipliers"
    extra = [f"{k} {getattr(trial, k)}" for k in ("at_limit", "too_sensitive", "warned") if getattr(trial, k)]
    times = " ".join(f"{k} {v:.1f} s" for k, v in trial.seconds.items())
    faults = (
        f"{len(trial.faults)} FAULTS, {len(trial.refused)} refused" if trial.faults or trial.refused else "no fault"
    )
    worst = f"worst {trial.worst_orbit:.2g} of what is allowed, multiplier {trial.worst_multiplier:.1e}"
    head = f"{trial.seed} {trial.family}: {trial.outcome}"
    if trial.outcome != "compared":
        return f"{head}: {trial.why[:200]}"
    return f"{head}, {counts}, {faults}; {', '.join([worst, *extra])}; {trial.attractors}; {times}"


def write_fault(folder, model, trial):
    """Write a run file of a model at fault, with what was said and what is true in its first lines."""
    lines = [
        f"# {where}\n#   said: {said}\n#   true: {true}\n" for where, said, true in [*trial.faults, *trial.refused]
    ]
    path = Path(folder) / f"{trial.family}_{trial.seed}.yaml"
    path.write_text("".join(lines) + "".join(f"# warning: {w}\n" for w in trial.warnings) + to_yaml(make_run(model)))


def main(first, number, folder=None):
    """Try so many models from a seed on; return the trials."""
    trials = []
    with tempfile.TemporaryDirectory() as scratch:
        for seed in range(first, first + number):
            model = draw_model(seed)
            trial = try_within(model, scratch)
            trials.append(trial)
            print(describe(trial), flush=True)
            for fault in trial.faults[:4]:
                print("    ", " | ".join(fault), flush=True)
            if folder is not None:
                with (Path(folder) / "trials.jsonl").open("a") as file:
                    file.write(json.dumps(asdict(trial)) + "\n")
                if trial.faults or trial.refused:
                    write_fault(folder, model, trial)
            for path in Path(scratch).iterdir():
                path.unlink()
    return trials


if __name__ == "__main__":
    tried = main(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:4])
    print(page([{"section": RANDOM, "trial": asdict(trial)} for trial in tried]))
