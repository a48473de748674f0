"""Times that can be compared: functions take turns in one process, so that what disturbs one disturbs all."""

from __future__ import annotations

import statistics
import time
import tracemalloc

import numpy as np


def timed(functions, repeats=15):
    """Return the median time of each function."""
    times = {name: [] for name in functions}
    for f in functions.values():
        f()
    for _ in range(repeats):
        for name, f in functions.items():
            start = time.perf_counter()
            f()
            times[name].append(time.perf_counter() - start)
    return {name: statistics.median(t) for name, t in times.items()}


def peak(f):
    """Return the largest memory that a call holds."""
    tracemalloc.start()
    f()
    size = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return size


def growth(sizes, times):
    """Return the exponent p of time ~ size^p by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])
