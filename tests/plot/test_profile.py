"""A state over one period, with its delayed values beside it."""

import numpy as np
import pytest

from tests.plot.drawn import lines
from tests.runs import run_model

TEXT = """\
name: pushed
states: [x, v]
parameters: {c: 0.3, K: 0.2, tau: 1.5}
forcing: {period: 2*pi}
modes: {only: {x': v, v': cos(t) - c*v - 2*x + K*v(t - tau)}}
run:
  steps:
    - {name: transient, simulate: {t_end: 60*pi}}
    - {name: orbit, orbit: {from: transient}}
"""


def test_delayed_values_are_the_state_as_much_later(tmp_path, show):
    results = run_model(TEXT, tmp_path / "a.h5")
    [axes] = show(results, "profile", ("orbit",), y="v").axes
    [own], [delayed] = lines(axes, "-"), lines(axes, "--")
    earlier = np.interp((delayed[:, 0] - 1.5) % (2 * np.pi), own[:, 0], own[:, 1])
    assert delayed[:, 1] == pytest.approx(earlier, abs=1e-4 * np.ptp(own[:, 1]))
    [axes] = show(results, "profile", ("orbit",), y="x").axes
    assert lines(axes, "--") == []
