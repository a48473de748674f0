"""What a computation costs: wall time, CPU time, memory."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any


@dataclass(frozen=True)
class Cost:
    """What a computation costs, in seconds and bytes.

    Seconds by the clock are the median, lowest and highest of the repeats, CPU seconds the median; bytes are those
    held at most by Python and arrays.
    """

    wall: float
    wall_low: float
    wall_high: float
    cpu: float
    memory: int


def measure_cost(compute: Callable[[], Any], repeats: int) -> tuple[Any, Cost]:
    """Return what ``compute`` returns and what it costs; a first run, which generates code, does not count."""
    result = compute()
    tracemalloc.start()
    try:
        compute()
        memory = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    walls, cpus = [], []
    for _ in range(repeats):
        wall, cpu = time.perf_counter(), time.process_time()
        compute()
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    return result, Cost(median(walls), min(walls), max(walls), median(cpus), memory)
