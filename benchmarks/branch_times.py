"""CPU time a point of branches, by whichever version of the program runs this: part of ``benchmarks.versions``.

Takes a file with a case (JSON): ``text`` of a model with its run, or of a run; ``source``, the file that it counts as;
and ``step``, whose time is asked for. Prints ``seconds`` of CPU, ``points``, and the first free parameter at special
points.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import sys
import tempfile
import time
from pathlib import Path

from pddecont.model import parse_document
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute

# The first time compiles the model's functions.
REPEATS = 2


def measure(case, folder):
    """Return what a case takes; the steps before the one that is asked for are done first."""
    plan = load_run_plan(parse_document(case["text"], case["source"]))
    names = [step.name for step in plan.steps]
    path, seconds = Path(folder) / "case.h5", []
    for _ in range(REPEATS):
        execute(plan, path, until=names[names.index(case["step"]) - 1], overwrite=True)
        start = time.process_time()
        execute(plan, path, until=case["step"], resume=True)
        seconds.append(time.process_time() - start)
    found = read_results(path).step(case["step"])
    free = list(plan.model.parameters).index(found.meta["free"][0])
    special = {label: float(found.points["parameters"][found.row(label), free]) for label in found.labels if label}
    return {"seconds": min(seconds), "points": len(found), "special": special}


def main():
    """Measure the case in the file that is named."""
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(measure(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")), folder)))


if __name__ == "__main__":
    main()
