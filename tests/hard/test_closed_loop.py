"""A closed branch of ten thousand points.

x' = 1 - x^2 - p^2 + 0.1 cos(2 pi t): the orbits near the circle x^2 + p^2 = 1 form a closed curve, which turns in p at
both sides.
"""

import subprocess
import sys

import numpy as np
import pytest

from pddecont.results import read_results
from tests.conftest import ROOT
from tests.runs import labels

MODEL = {
    "name": "loop",
    "states": ["x"],
    "parameters": {"p": 0.3},
    "forcing": {"period": 1},
    "modes": {"m": {"x'": "1 - x**2 - p**2 + 0.1*cos(2*pi*t)"}},
    "initial": {"x": 1},
    "run": {
        "mesh": {"degree": 8, "intervals": 2},
        "monitors": {"x": "mean(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 60}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["p"],
                    "range": {"p": [-2, 2]},
                    "direction": "up",
                    "max_points": 200,
                    "step": {"initial": 0.027, "max": 0.027},
                    "events_along": {"home": "p - 0.3"},
                },
            },
        ],
    },
}


# A process of its own, whose largest size is that of these branches: first a short one, so that all is loaded, then the
# long one.
SCRIPT = """
import resource, sys
from pathlib import Path
from tests.hard.test_closed_loop import MODEL
from tests.runs import change, run
for points in (200, 10200):
    run(change(MODEL, "run.steps.2.continue.max_points", points), Path(sys.argv[1]))
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_ten_thousand_points_return_to_their_start(tmp_path, record):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, tmp_path / "a.h5"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    few, many = map(int, done.stdout.split())
    step = read_results(tmp_path / "a.h5").step("c")
    home = [i for i in step.order if step.labels[i].startswith("UF")]
    assert len(home) >= 2, labels(step)
    lower, back = home[:2]
    assert step.points["monitors"][lower, 0] < 0 < step.points["monitors"][back, 0]
    assert sum(step.points["arclength"] <= step.points["arclength"][back]) > 10_000
    start = np.append(step.orbit(0)["states"].ravel(), step.points["parameters"][0])
    gap = np.max(np.abs(np.append(step.orbit(back)["states"].ravel(), step.points["parameters"][back]) - start))
    record("10,000 points round a closed branch: back at the start", "the start", gap, 1e-8)
    record(
        "the other half: mirror image", "x -> -x, t -> -t", abs(np.sum(step.points["monitors"][[lower, 0], 0])), 1e-12
    )
    # A point that stayed in memory with its problem and factors would take 50 KiB and more.
    record("memory, KiB a point more than for 200 points", "none is kept", (many - few) / 10_000, 10)
