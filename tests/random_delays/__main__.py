"""Random models with delays of every kind by the number: ``python -m tests.random_delays FIRST NUMBER [FOLDER]``.

Each model is one line. FOLDER gets ``trials.jsonl``, one model a line, and the run files of models at fault.
"""

from __future__ import annotations

import json
import signal
import sys
import tempfile
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from tests.random_delays.generator import draw_model
from tests.random_delays.trial import Trial, make_run, try_model
from tests.random_models.trial import TOO_LONG
from tests.runs import to_yaml

# Seconds of processor time for one model.
LIMIT = 150.0


class _TookTooLongError(BaseException):
    """Raised in the middle of whatever a trial does; nothing there takes it for one of its own errors."""


def try_within(drawn, folder, limit=LIMIT):
    """Return the trial of a model, or that it took longer than the limit."""

    def give_up(*_):
        raise _TookTooLongError

    before = signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        return try_model(drawn, folder)
    except _TookTooLongError:
        return Trial(drawn.model.seed, drawn.model.family, drawn.kinds, TOO_LONG, f"more than {limit:g} s")
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def describe(trial):
    """Return a trial as one line."""
    head = f"{trial.seed} {trial.family} ({', '.join(trial.kinds)}): {trial.outcome}"
    times = " ".join(f"{k} {v:.1f} s" for k, v in trial.seconds.items())
    if trial.outcome != "compared":
        return f"{head}: {trial.why[:300]}; {times}"
    faults = f"{len(trial.faults)} FAULTS" if trial.faults else "no fault"
    return f"{head}, {trial.n_points} points, {faults}, worst {trial.worst:.2g} of what is allowed; {times}"


def main(first, number, folder=None):
    """Try so many models from a seed on; return the trials."""
    trials = []
    with tempfile.TemporaryDirectory() as scratch:
        for seed in range(first, first + number):
            drawn = draw_model(seed)
            trial = try_within(drawn, scratch)
            trials.append(trial)
            print(describe(trial), flush=True)
            for fault in trial.faults[:3]:
                print("    ", " | ".join(fault), flush=True)
            if folder is not None:
                with (Path(folder) / "trials.jsonl").open("a") as file:
                    file.write(json.dumps(asdict(trial)) + "\n")
                if trial.faults or trial.outcome != "compared":
                    (Path(folder) / f"{trial.family}_{seed}.yaml").write_text(to_yaml(make_run(drawn.model)))
            for path in Path(scratch).iterdir():
                path.unlink()
    return trials


if __name__ == "__main__":
    tried = main(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:4])
    print(Counter(t.outcome for t in tried), sum(t.n_points for t in tried), "points")
    print("worst", max(t.worst for t in tried), "at fault", [t.seed for t in tried if t.faults])
