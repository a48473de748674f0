"""Integrations interrupted at random instants, in one process: ``python -m tests.faults.interrupted NUMBER SEED``.

A signal that comes while machine code runs becomes an exception as soon as Python runs again, and that must not be
within what machine code does on its way back. Prints how many were interrupted; a process that dies prints nothing.
"""

from __future__ import annotations

import contextlib
import random
import signal
import sys

from pddecont.delay import Direct
from pddecont.simulate import ReturnSettings, Simulator, find_attractor, find_lyapunov_exponent
from tests.conftest import shipped

NEVER = 1e12


def main(number, seed):
    rng, interrupted = random.Random(int(seed)), 0
    numeric = shipped("wall_oscillator")
    simulator = Simulator(numeric, Direct())
    values = simulator.values(numeric.parameter_values)
    settings = ReturnSettings(numeric.period.value(numeric.parameter_values)[0], 0.0, 200.0, 4, 50)
    simulator.advance(values, simulator.start(values), 1.0)
    attractor = find_attractor(simulator, values, simulator.start(values), settings)
    find_lyapunov_exponent(simulator, values, attractor, 50.0)
    ways = (
        lambda: simulator.advance(values, simulator.start(values), NEVER),
        lambda: simulator.advance(values, simulator.start(values), 1.0),
        lambda: find_attractor(simulator, values, simulator.start(values), settings),
        lambda: find_lyapunov_exponent(simulator, values, attractor, 5.0),
    )

    def interrupt(*_):
        raise KeyboardInterrupt

    signal.signal(signal.SIGALRM, interrupt)
    for k in range(int(number)):
        with contextlib.suppress(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, rng.uniform(1e-3, 2e-2))
            while True:
                ways[k % len(ways)]()
        interrupted += 1
    print(interrupted)


if __name__ == "__main__":
    main(*sys.argv[1:])
