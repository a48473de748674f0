"""A closed branch of ten thousand points.

x' = 1 - x^2 - p^2 + 0.1 cos(2 pi t): the orbits near the circle x^2 + p^2 = 1 form a closed curve, which turns in p at both sides.
"""

import resource

import numpy as np
import pytest

from tests.runs import labels, run_model

MODEL = """
name: loop
states: [x]
parameters: {p: 0.3}
forcing: {period: 1}
modes: {m: {x': 1 - x**2 - p**2 + 0.1*cos(2*pi*t)}}
initial: {x: 1}
run:
  mesh: {degree: 8, intervals: 2}
  monitors: {x: mean(x)}
  steps:
    - {name: t, simulate: {t_end: 60}}
    - {name: o, orbit: {from: t}}
    - name: c
      continue:
        {from: o, free: [p], range: {p: [-2, 2]}, direction: up, max_points: POINTS, step: {initial: 0.027, max: 0.027},
         events_along: {home: p - 0.3}}
"""


@pytest.mark.slow
def test_ten_thousand_points_return_to_their_start(tmp_path, record):
    run_model(MODEL.replace("POINTS", "200"), tmp_path / "short.h5")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    step = run_model(MODEL.replace("POINTS", "10200"), tmp_path / "a.h5").step("c")
    kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    home = [i for i in step.order if step.labels[i].startswith("UF")]
    assert len(home) >= 2, labels(step)
    lower, back = home[:2]
    assert step.points["monitors"][lower, 0] < 0 < step.points["monitors"][back, 0]
    assert sum(step.points["arclength"] <= step.points["arclength"][back]) > 10_000
    start = np.append(step.orbit(0)["states"].ravel(), step.points["parameters"][0])
    gap = np.max(np.abs(np.append(step.orbit(back)["states"].ravel(), step.points["parameters"][back]) - start))
    record("10,000 points round a closed branch: back at the start", "the start", gap, 1e-8)
    record("the other half: mirror image", "x -> -x, t -> -t", abs(np.sum(step.points["monitors"][[lower, 0], 0])), 1e-12)
    # Less than 8 KiB a point, of which the recorded orbits themselves are 2: nothing of a point is kept but what is in the file.
    record("its memory, MiB more than a branch of 200 points", "none but what the file holds", kib / 1024, 80)
