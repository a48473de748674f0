"""Work in chunks: on one core, on many, or on a Dask cluster, with the same results in the same order.

Whoever computes a chunk, its result depends on the chunk alone, and results come back in the order of the chunks.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

from pddecont.errors import RunError
from pddecont.simulate.slots import Slots

Chunk = TypeVar("Chunk")
Result = TypeVar("Result")
# Chunks handed out ahead for each worker: enough to keep it busy while a slow one is waited for.
AHEAD = 4
# How often a chunk is tried again whose worker was lost.
RETRIES = 5


@dataclass(frozen=True)
class Workers:
    """Who computes: threads of this process, or the workers of a Dask scheduler.

    The integrator runs outside Python's lock. Threads take ``slots``, where other things are computed meanwhile.
    """

    number: int = 1
    scheduler: str | None = None
    slots: Slots | None = None


def map_in_order(workers: Workers, work: Callable[[Chunk], Result], chunks: Sequence[Chunk]) -> Iterator[Result]:
    """Yield ``work(chunk)`` for each chunk, in order; chunks are handed out as results are taken.

    What ``work`` holds is sent to a worker once and is kept there for all its chunks.
    """
    if workers.scheduler is None and workers.number == 1:
        yield from map(work, chunks)
        return
    with contextlib.ExitStack() as stack:
        if workers.slots is not None:
            stack.enter_context(workers.slots.share())
        submit, n = _make_submit(workers, work, stack)
        waiting: deque[Future[Result]] = deque()
        stack.callback(lambda: [future.cancel() for future in waiting])
        for chunk in chunks:
            waiting.append(submit(chunk))
            if len(waiting) < AHEAD * n:
                continue
            yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _make_submit(
    workers: Workers, work: Callable[[Chunk], Result], stack: contextlib.ExitStack
) -> tuple[Callable[[Chunk], Future[Result]], int]:
    """Return a function that hands out a chunk, and how many are computed at once; ``stack`` closes what it needs."""
    if workers.scheduler is None:
        pool = stack.enter_context(ThreadPoolExecutor(workers.number))
        return lambda chunk: pool.submit(_apply_in_slot, workers.slots, work, chunk), workers.number
    client = stack.enter_context(connect(workers.scheduler))
    n = max(1, sum(client.nthreads().values()))
    executor = stack.enter_context(client.get_executor(retries=RETRIES, pure=False))
    # A result on the cluster: workers fetch it once, and it is computed anew if the worker that holds it is lost.
    shared = client.submit(_identity, work, retries=RETRIES, pure=False)
    return lambda chunk: executor.submit(_apply, shared, chunk), n


def _identity(work: Callable[[Chunk], Result]) -> Callable[[Chunk], Result]:
    return work


def _apply(work: Callable[[Chunk], Result], chunk: Chunk) -> Result:
    return work(chunk)


def _apply_in_slot(slots: Slots | None, work: Callable[[Chunk], Result], chunk: Chunk) -> Result:
    with contextlib.nullcontext() if slots is None else slots.hold():
        return work(chunk)


def connect(address: str) -> Any:
    """Return a client of the Dask scheduler at an address."""
    try:
        from distributed import Client
    except ImportError as exc:
        raise RunError.at("--scheduler", 0, 0, "needs Dask; install it with: pip install 'pddecont[cluster]'") from exc
    try:
        connect: Callable[..., Any] = Client
        return connect(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as exc:
        raise RunError.at(f"--scheduler {address}", 0, 0, f"no Dask scheduler answers there: {exc}") from exc
