"""One piece of work in a process of its own, or on a Dask cluster, while this one goes on.

The other process is this Python's, started anew: it gets the work through a pipe and ends with this one, whose end it
sees by the pipe. What comes through the pipe is this program's own.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TypeVar

from pddecont.simulate.workers import RETRIES, Workers, connect

# The other process finds modules where this one does, and nowhere else: not in the folder that it is started in.
START = f"import json, sys; sys.path[:] = json.loads(sys.argv[1]); from {__name__} import main; main()"
Task = TypeVar("Task")
Result = TypeVar("Result")


@contextlib.contextmanager
def begin_apart(workers: Workers, work: Callable[[Task], Result], task: Task) -> Iterator[Callable[[], Result]]:
    """Begin ``work(task)`` elsewhere; yield what waits for the result.

    Where the other process is lost, the work is done here. What is not waited for ends with the context.
    """
    if workers.scheduler is not None:
        with connect(workers.scheduler) as client:
            future = client.submit(work, task, retries=RETRIES, pure=False)
            try:
                yield future.result
            finally:
                future.cancel()
        return
    command = [sys.executable, "-P", "-c", START, json.dumps(sys.path)]
    # A signal from the keyboard is this process's to answer.
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True) as process:
        assert process.stdin is not None and process.stdout is not None, "both are pipes"
        stream, tasks = process.stdout, process.stdin
        with contextlib.suppress(BrokenPipeError):
            pickle.dump((work, task), tasks)
            tasks.flush()

        def wait() -> Result:
            try:
                result: Result = pickle.load(stream)
            except EOFError:
                result = work(task)
            return result

        try:
            yield wait
        finally:
            process.kill()
            with contextlib.suppress(BrokenPipeError):
                tasks.close()


def _end_with_parent() -> None:
    """End when the pipe from the parent does."""
    sys.stdin.buffer.read(1)
    os._exit(1)


def main() -> None:
    """Do the work that comes through the pipe."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    # What else is printed is no part of the answer.
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    work, task = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    pickle.dump(work(task), answers)
    answers.flush()
