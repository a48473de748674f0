"""What finding out what to do costs ``explore``: its CPU time against that of its steps, written by hand.

The steps are those that the file holds in the end: sweeps, orbits, branches, curves. Beside them an exploration flies a
few motions, looks at all that settle, and does steps again that lead to what is known.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import tempfile
import time
from pathlib import Path

import yaml

from pddecont.model import parse_document
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute

ROOT = Path(__file__).parent.parent
# Ranges of models.
CASES = {
    "wall_oscillator": {"wall": [0.1, 0.6]},
    "impact_oscillator": {"K": [0, 0.3]},
    "bouncing_ball": {"G": [0.3, 1.0]},
    "mackey_glass": {"tau": [0.1, 1.3]},
}
SHARED = ("delay", "mesh", "monitors")


def load(document):
    """Return the plan of a run."""
    return load_run_plan(parse_document(yaml.safe_dump(document), str(ROOT / "configs" / "bench.yaml")))


def make_exploration(name, over):
    """Return the run that explores a model."""
    path = ROOT / "models" / f"{name}.yaml"
    own = yaml.safe_load(path.read_text(encoding="utf-8"))["run"]
    shared = {key: own[key] for key in SHARED if key in own}
    return {"model": str(path), **shared, "steps": [{"name": "all", "explore": {"over": over}}]}


def write_by_hand(exploration, path):
    """Return a run of the steps that an exploration has in its file."""
    steps = [json.loads(step.meta["settings"])["step"] for step in read_results(path).steps.values()]
    kept = [drop_empty(step) for step in steps if "explore" not in step]
    return {**exploration, "steps": kept}


def drop_empty(value):
    """Return settings without those that say nothing."""
    if isinstance(value, dict):
        return {key: drop_empty(one) for key, one in value.items() if one is not None}
    return [drop_empty(one) for one in value] if isinstance(value, list) else value


def measure(plan, path):
    """Return the CPU seconds of a run."""
    start = time.process_time()
    execute(plan, path, overwrite=True)
    return time.process_time() - start


def main(repeats=2):
    """Print the ratios."""
    print(f"{'explored':20} {'steps':>5} {'s':>7} {'by hand, s':>10} {'ratio':>6}")
    with tempfile.TemporaryDirectory() as folder:
        explored, written = Path(folder) / "explored.h5", Path(folder) / "written.h5"
        for name, over in CASES.items():
            exploration = make_exploration(name, over)
            times = {"explored": [], "written": []}
            for _ in range(repeats):
                times["explored"].append(measure(load(exploration), explored))
                by_hand = write_by_hand(exploration, explored)
                times["written"].append(measure(load(by_hand), written))
            least = {key: min(found) for key, found in times.items()}
            n = len(by_hand["steps"])
            ratio = least["explored"] / least["written"]
            print(f"{name:20} {n:5} {least['explored']:7.2f} {least['written']:10.2f} {ratio:6.2f}", flush=True)


if __name__ == "__main__":
    main()
