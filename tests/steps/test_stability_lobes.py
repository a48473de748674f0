"""Stability lobes of turning, x'' + 2 zeta x' + x = -w (x - x(t - tau)), as curves of Hopf points.

Roots i W of W^2 - 1 - 2 i zeta W = w (1 - exp(-i W tau)) lie on

    w = ((1 - W^2)^2 + 4 zeta^2 W^2) / (2 (W^2 - 1)),    tau = (2/W) (j pi - atan((W^2 - 1) / (2 zeta W)))

with W > 1 for positive widths and W < 1 for negative ones.
"""

import math

import numpy as np
import pytest

from pddecont.model import parse_document
from pddecont.tables import describe_endings
from tests.conftest import ROOT
from tests.runs import parameter, run

ZETA, N_LOBES = 0.02, 20
# Where each lobe is nearest to w = 0, and how far it is there: W^2 = 1 +- 2 zeta.
FAMILIES = {"cutting": 1.0, "pulled": -1.0}


def width(W):
    return ((1 - W**2) ** 2 + 4 * ZETA**2 * W**2) / (2 * (W**2 - 1))


def delay(W, j):
    return 2 / W * (j * math.pi - np.arctan((W**2 - 1) / (2 * ZETA * W)))


def follow_lobe(sign, j):
    """Return the steps that follow a lobe: to its place nearest to w = 0 over the width, and along it."""
    W = math.sqrt(1 + sign * 2 * ZETA)
    tau, nearest = float(delay(W, j)), float(width(W))
    inside, outside = sorted([0.5 * nearest, 1.02 * nearest]), sorted([0.5 * nearest, sign * 0.2])
    start = {"w": 0.6 * nearest, "tau": tau}
    rest = {"from": {"x": 0, "v": 0}, "mode": "cut1"}
    in_width = {"from": f"rest{j}", "free": ["w"], "range": {"w": inside}}
    lobe = {
        "from": {"step": f"in_width{j}", "point": "HB1"},
        "free": ["tau", "w"],
        "range": {"tau": [max(tau - 4.0, 0.01), tau + 4.0], "w": outside},
    }
    return [
        {"name": f"rest{j}", "set": start, "equilibrium": rest},
        {"name": f"in_width{j}", "continue": in_width},
        {"name": f"lobe{j}", "continue": lobe},
    ]


def check(step, j, sign):
    W = step.points["frequency"][step.order]
    assert len(W) > 10
    assert np.all(sign * (W - 1) > 0.0)
    assert parameter(step, "w") == pytest.approx(width(W), abs=1e-10)
    assert parameter(step, "tau") == pytest.approx(delay(W, j), abs=1e-10)
    assert not any("not located" in text for text in describe_endings(step))


# Those of the shipped model are for every day.
@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_each_lobe_is_its_closed_form(family, tmp_path):
    sign = FAMILIES[family]
    # The first lobe of negative widths begins at tau = 0.
    first = 1 if sign > 0.0 else 0
    lobes = range(first, first + N_LOBES)
    steps = [step for j in lobes for step in follow_lobe(sign, j)]
    results = run({"model": "turning", "steps": steps}, tmp_path / "a.h5")
    for j in lobes:
        step = results.step(f"lobe{j}")
        check(step, j, sign)
        W = math.sqrt(1 + sign * 2 * ZETA)
        nearest = results.step(f"in_width{j}")
        assert parameter(nearest, "w", "HB1") == pytest.approx(sign * 2 * ZETA * (1 + sign * ZETA), abs=1e-10)
        assert nearest.points["frequency"][nearest.row("HB1")] == pytest.approx(W, abs=1e-10)


def test_the_shipped_lobes_are_their_closed_forms(tmp_path):
    path = ROOT / "configs" / "turning_lobes.yaml"
    results = run(parse_document(path.read_text(), str(path)).data, tmp_path / "a.h5")
    for j in range(1, 5):
        check(results.step(f"lobe{j}"), j, 1.0)
        check(results.step(f"pulled{j}"), j - 1, -1.0)
