"""Pieces of work done elsewhere while this process goes on: in other processes, or on the workers of a Dask scheduler.

Whoever does a piece, what comes of it depends on the piece alone.
"""

from __future__ import annotations

import contextlib
import pickle
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from pddecont.simulate.other_process import Lost, OtherProcess
from pddecont.simulate.slots import Slots
from pddecont.simulate.workers import RETRIES, Workers, connect

Task = TypeVar("Task")
Result = TypeVar("Result")


class Place(Protocol):
    """Where work is done; each of several threads asks for one piece at a time."""

    def enter(self) -> None:
        """Make ready for work that the calling thread will ask for."""
        ...

    def ask(self, work: Callable[[Any, Task], Result], task: Task) -> Result:
        """Return ``work(shared, task)``; raise Lost if whoever did it is lost."""
        ...

    def end(self) -> None:
        """End all that is being done."""
        ...

    def close(self) -> None:
        """Let go of what is held, once nobody asks any more."""
        ...


@dataclass(frozen=True, eq=False)
class Elsewhere:
    """Where pieces of work are begun early; whoever does one takes one of ``slots``."""

    slots: Slots
    place: Place
    pool: ThreadPoolExecutor
    on_cluster: bool

    def prepare(self, work: Callable[[Any, None], None]) -> None:
        """Let other processes start, and do ``work(shared, None)`` there, before anything is begun; a cluster is there.

        One fewer than there are places: this process is one of those that compute.
        """
        for _ in range(0 if self.on_cluster else self.slots.number - 1):
            self.pool.submit(self.place.ask, work, None)

    def begin(self, work: Callable[[Any, Task], Result], task: Task) -> Future[Result] | None:
        """Begin ``work(shared, task)``; None if nobody is free."""
        if not self.slots.take_early():
            return None
        future = self.pool.submit(self.place.ask, work, task)
        future.add_done_callback(lambda _: self.slots.give())
        return future

    def wait(self, future: Future[Result]) -> Result | None:
        """Return what came of a piece of work; None if it is to be done here.

        That is so if whoever did it was lost, or a process that is to do it is not there yet. Whoever waits leaves the
        seat.
        """
        if self.take_back(future):
            return None
        self.slots.stand()
        try:
            return future.result()
        except Lost:
            return None

    def take_back(self, future: Future[Result]) -> bool:
        """Return whether a piece of work that has not begun need not be done elsewhere any more."""
        return future.cancel()


@contextlib.contextmanager
def open_elsewhere(workers: Workers, shared: object) -> Iterator[Elsewhere]:
    """Yield where work is done that shares something; what is not done yet ends with the context."""
    data = pickle.dumps(shared)
    with contextlib.ExitStack() as stack:
        place: Place
        if workers.scheduler is None:
            place, number = _OtherProcesses(data), workers.number
            # While this process waits it has no part in computing, and another one may.
            n_threads = number
        else:
            client = stack.enter_context(connect(workers.scheduler))
            place, n_threads = _Cluster(client, data), max(1, sum(client.nthreads().values()))
            number = n_threads + 1
        stack.callback(place.close)
        with ThreadPoolExecutor(n_threads, initializer=place.enter) as pool:
            try:
                yield Elsewhere(Slots(number), place, pool, workers.scheduler is not None)
            finally:
                pool.shutdown(wait=False, cancel_futures=True)
                place.end()


class _OtherProcesses:
    """Processes, one for each thread that asks."""

    def __init__(self, shared: bytes):
        self._shared = shared
        self._lock = threading.Lock()
        self._all: list[OtherProcess] = []
        self._own = threading.local()
        self._is_over = False

    def enter(self) -> None:
        """Start the calling thread's process."""
        self._own.process = None
        with self._lock, contextlib.suppress(OSError):
            self._own.process = OtherProcess(self._shared)
            self._all.append(self._own.process)
            if self._is_over:
                self._own.process.kill()
        if self._own.process is not None:
            self._own.process.make_ready()

    def ask(self, work: Callable[[Any, Task], Result], task: Task) -> Result:
        """Return ``work(shared, task)``; raise Lost if the process is lost; the next piece is another's."""
        if self._own.process is None:
            self.enter()
        process: OtherProcess | None = self._own.process
        if process is None:
            raise Lost
        try:
            return process.ask(work, task)
        except Lost:
            self._own.process = None
            raise

    def end(self) -> None:
        """Kill all processes."""
        with self._lock:
            self._is_over = True
            for process in self._all:
                process.kill()

    def close(self) -> None:
        """Close what led to the processes."""
        for process in self._all:
            process.close()


class _Cluster:
    """The workers of a Dask scheduler."""

    def __init__(self, client: Any, shared: bytes):
        self._client = client
        # A result on the cluster: workers fetch it once, and it is there again if the worker that holds it is lost.
        self._shared = client.submit(_identity, shared, retries=RETRIES, pure=False)
        self._begun: set[Any] = set()

    def enter(self) -> None:
        """Do nothing: its workers are there."""

    def ask(self, work: Callable[[Any, Task], Result], task: Task) -> Result:
        """Return ``work(shared, task)``; raise Lost if that was begun often enough and the worker was always lost."""
        from distributed import CancelledError, KilledWorker

        future = self._client.submit(_do, work, self._shared, task, retries=RETRIES, pure=False)
        self._begun.add(future)
        try:
            result: Result = future.result()
        except (KilledWorker, CancelledError, OSError) as exc:
            raise Lost from exc
        finally:
            self._begun.discard(future)
        return result

    def end(self) -> None:
        """Cancel what is being done."""
        for future in list(self._begun):
            future.cancel()

    def close(self) -> None:
        """Do nothing: the client is closed by whoever opened it."""


def _identity(shared: bytes) -> bytes:
    return shared


def _do(work: Callable[[Any, Task], Result], shared: bytes, task: Task) -> Result:
    """Do a piece of work with a copy of its own of what is shared: a worker may have several threads."""
    return work(pickle.loads(shared), task)
