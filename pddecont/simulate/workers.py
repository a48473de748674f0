"""Work in chunks: on one core, on many, or on a Dask cluster, with the same results in the same order.

Whoever computes a chunk, its result depends on the chunk alone, and results come back in the order of the chunks.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

from pddecont.errors import RunError

Chunk = TypeVar("Chunk")
Result = TypeVar("Result")
# Chunks handed out ahead for each worker: enough to keep it busy while a slow one is waited for.
AHEAD = 4
# How often a chunk is tried again whose worker was lost.
RETRIES = 5


@dataclass(frozen=True)
class Workers:
    """Who computes: threads of this process (the integrator runs outside Python's lock), or the workers of a Dask scheduler."""

    number: int = 1
    scheduler: str | None = None


def in_order(workers: Workers, work: Callable[[Chunk], Result], chunks: Sequence[Chunk]) -> Iterator[Result]:
    """Yield ``work(chunk)`` for each chunk, in order; chunks are handed out as results are taken."""
    if workers.scheduler is None and workers.number == 1:
        yield from map(work, chunks)
        return
    with contextlib.ExitStack() as stack:
        executor, n = _executor(workers, stack)
        waiting: deque[Future[Result]] = deque()
        stack.callback(lambda: [future.cancel() for future in waiting])
        todo = iter(chunks)
        for chunk in todo:
            waiting.append(executor.submit(work, chunk))
            if len(waiting) < AHEAD * n:
                continue
            yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _executor(workers: Workers, stack: contextlib.ExitStack) -> tuple[Executor, int]:
    if workers.scheduler is None:
        return stack.enter_context(ThreadPoolExecutor(workers.number)), workers.number
    client = stack.enter_context(_client(workers.scheduler))
    n = max(1, sum(client.nthreads().values()))
    return stack.enter_context(client.get_executor(retries=RETRIES, pure=False)), n


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as exc:
        raise RunError.at("--scheduler", 0, 0, "needs Dask; install it with: pip install 'pddecont[cluster]'") from exc
    try:
        return Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as exc:
        raise RunError.at(f"--scheduler {address}", 0, 0, f"no Dask scheduler answers there: {exc}") from exc
