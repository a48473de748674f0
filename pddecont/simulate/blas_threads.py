"""One thread for the linear algebra of numpy and scipy while something is computed, and as many as before after it.

The matrices here are too small to share among threads: with as many as there are cores a run takes several times as
long, and the last digits are others. The command line tells the libraries before they are loaded, and so does a process
that is started to compute; to a program that has loaded them the limit is lent.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from typing import Any

# Who has set one of these has chosen; the libraries have read it.
CHOSEN = {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"}


class _Limit:
    """The limit that is lent: by how many at once, as runs in two threads of a program end in any order."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.n_held = 0
        self.lent: Any = None

    def take(self) -> None:
        """Set the limit if nobody has it yet."""
        with self.lock:
            self.n_held += 1
            if self.n_held == 1:
                self.lent = _set_limit()

    def give_back(self) -> None:
        """Take the limit back if nobody else has it."""
        with self.lock:
            self.n_held -= 1
            if not self.n_held and self.lent is not None:
                self.lent.restore_original_limits()
                self.lent = None


_LIMIT = _Limit()


@contextlib.contextmanager
def lend_one_thread() -> Iterator[None]:
    """Keep the linear algebra of this process to one thread for a while, unless the environment says how many."""
    if not CHOSEN.isdisjoint(os.environ):
        yield
        return
    _LIMIT.take()
    try:
        yield
    finally:
        _LIMIT.give_back()


def list_environment() -> dict[str, str]:
    """Return the environment of a process that computes for this one: it has as many threads as this one then."""
    chosen = {} if not CHOSEN.isdisjoint(os.environ) else {"OPENBLAS_NUM_THREADS": "1"}
    return {**os.environ, **chosen}


def _set_limit() -> Any:
    """Return what restores the numbers of threads that there were; None where threadpoolctl is not installed."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        # It is asked for, but nothing that is computed depends on it.
        return None
    return threadpool_limits(limits=1, user_api="blas")
