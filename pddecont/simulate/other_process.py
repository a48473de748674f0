"""Another process, this Python's, started anew: it does one piece of work after another while this one goes on.

It gets work through a pipe and ends with this process, whose end it sees by the pipe. What comes through the pipe is
this program's own. All work shares something that is sent once, so that what is made of it is made once.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from pddecont.simulate.blas_threads import list_environment

# The other process finds modules where this one does, and nowhere else: not in the folder that it is started in.
START = f"import json, sys; sys.path[:] = json.loads(sys.argv[1]); from {__name__} import main; main()"
READY = "ready"
Task = TypeVar("Task")
Result = TypeVar("Result")


class Lost(Exception):
    """Whoever did a piece of work is lost: it is to be done again."""


class OtherProcess:
    """A process that does pieces of work that share something (``shared``, pickled)."""

    def __init__(self, shared: bytes):
        command = [sys.executable, "-P", "-c", START, json.dumps(sys.path)]
        # A signal from the keyboard is this process's to answer.
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True, env=list_environment()
        )
        self._shared = shared

    def make_ready(self) -> None:
        """Send what all work shares; wait until it has arrived, or the process is lost."""
        with contextlib.suppress(Lost):
            self._send(self._shared)
            self._receive()

    def ask(self, work: Callable[[Any, Task], Result], task: Task) -> Result:
        """Return ``work(shared, task)``; raise Lost if the process ends before."""
        self._send(pickle.dumps((work, task)))
        result: Result = self._receive()
        return result

    def kill(self) -> None:
        """End it, whatever it does."""
        self._process.kill()

    def close(self) -> None:
        """Wait until it has ended, and close what led to it."""
        assert self._process.stdin is not None and self._process.stdout is not None, "both are pipes"
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()

    def _send(self, data: bytes) -> None:
        assert self._process.stdin is not None, "it is a pipe"
        try:
            self._process.stdin.write(data)
            self._process.stdin.flush()
        except BrokenPipeError as exc:
            raise Lost from exc

    def _receive(self) -> Any:
        assert self._process.stdout is not None, "it is a pipe"
        try:
            return pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError) as exc:
            # It ended before its answer, or in the middle of it.
            raise Lost from exc


def _read_all(received: queue.SimpleQueue[Any]) -> None:
    """Take in what comes through the pipe; end when the pipe does, whatever is being done."""
    try:
        while True:
            received.put(pickle.load(sys.stdin.buffer))
    finally:
        os._exit(1)


def main() -> None:
    """Do the work that comes through the pipe."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    # What else is printed is no part of the answers.
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    received: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_read_all, args=(received,), daemon=True).start()
    shared, answer = received.get(), pickle.dumps(READY)
    while True:
        try:
            answers.write(answer)
            answers.flush()
            work, task = received.get()
            answer = pickle.dumps(work(shared, task))
        except Exception:
            # What goes wrong here goes wrong where the work is done instead, and is told there.
            os._exit(1)
