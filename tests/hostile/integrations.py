"""States of integrations with numbers changed, gone on with in forks: ``python -m tests.hostile.integrations FILE
NUMBER``.

Prints one JSON object: how many were gone on with, how many refused, and the seeds of those that ended their process.
"""

import contextlib
import json
import os
import signal
import sys
from pathlib import Path

import numpy as np

from pddecont.errors import PddecontError
from pddecont.native.integrator import T
from pddecont.results import read_results
from pddecont.simulate import MotionTask, record_trajectory, unpack
from pddecont.steps.execution.attractor_rows import attractor_from_row
from tests.faults.runs import plan_of

VALUES = [-1.0, 0.0, 1.0, 2.0, 64.0, 1e3, 1e9, 2.0**31, 2.0**62, -(2.0**63), np.nan, np.inf, 1e-300]

ACCEPTED, REFUSED = 10, 11


def go_on(simulator, attractor, row):
    """Go on with an integration for some time; return whether its state was accepted."""
    try:
        state = unpack(simulator.system, simulator.values(attractor.p), row)
    except ValueError:
        return False
    with contextlib.suppress(PddecontError), np.errstate(all="ignore"):
        record_trajectory(simulator, attractor.p, state, float(state.clock[T]) + 20.0)
    return True


def main(file, number):
    plan = plan_of("sweep")
    step = plan.steps[-1]
    settling = step.settings.settling
    simulator = MotionTask(plan.numeric, step.delay, settling.method, settling.section).make_simulator()
    attractor = attractor_from_row(read_results(Path(file)).step("last"), 2)
    assert go_on(simulator, attractor, attractor.packed_state)
    found = {"accepted": 0, "refused": 0, "late": 0, "ended": []}
    for seed in range(int(number)):
        rng, row = np.random.default_rng(seed), attractor.packed_state.copy()
        for _ in range(rng.integers(1, 4)):
            # The first numbers are times, counts and names of things.
            row[rng.integers(0, 25) if rng.random() < 0.7 else rng.integers(0, len(row))] = rng.choice(VALUES)
        if rng.random() < 0.1:
            row = row[: rng.integers(0, len(row))]
        child = os.fork()
        if not child:
            signal.alarm(5)
            os._exit(ACCEPTED if go_on(simulator, attractor, row) else REFUSED)
        status = os.waitpid(child, 0)[1]
        if os.WIFEXITED(status) and os.WEXITSTATUS(status) in (ACCEPTED, REFUSED):
            found["refused" if os.WEXITSTATUS(status) == REFUSED else "accepted"] += 1
        elif os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGALRM:
            found["late"] += 1  # times that are far apart take long to cross: Ctrl-C ends that
        else:
            found["ended"].append((seed, status))
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
