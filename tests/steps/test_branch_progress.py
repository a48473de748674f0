"""How far a branch says it has come."""

import numpy as np
import pytest

from pddecont.steps.execution import execute
from pddecont.steps.execution.branch_progress import RangeCovered
from tests.cli.test_cli import QUICK
from tests.runs import plan


def test_the_share_is_what_was_covered_of_the_range_both_ways_and_never_shrinks():
    covered = RangeCovered(["K"], [(0.0, 2.0)])
    shares = [covered.describe(n, [K], "")[1] for n, K in enumerate((0.5, 1.0, 0.8, 2.0, 0.5, 0.25, 0.0))]
    assert shares == pytest.approx([0, 0.25, 0.25, 0.75, 0.75, 0.875, 1])
    assert covered.describe(7, [0.125], "LP")[0] == "7 points, K = 0.125 LP"


def test_of_a_curve_the_parameter_counts_that_is_nearer_to_its_end():
    covered = RangeCovered(["a", "b"], [(0.0, 1.0), (0.0, 10.0)])
    covered.describe(1, [0.2, 1.0], "")
    assert covered.describe(2, [0.3, 6.0], "")[1] == pytest.approx(0.5)
    assert RangeCovered(["a"], [(0.0, np.inf)]).describe(1, [3.0], "")[1] == 0


def test_a_run_hears_it(tmp_path):
    class Listener:
        def __init__(self):
            self.shares = []

        def progress(self, text, fraction=None):
            self.shares.append(fraction)

        def step(self, name, kind):
            self.shares.clear()

        def __getattr__(self, name):
            return lambda *_: None

    listener = Listener()
    execute(plan(QUICK), tmp_path / "q.h5", listener)
    assert listener.shares[0] == 0 and listener.shares[-1] == pytest.approx(1)
    assert listener.shares == sorted(listener.shares)
