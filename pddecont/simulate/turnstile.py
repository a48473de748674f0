"""A turnstile: threads that have given a place back begin what may be early, one at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Turnstile:
    """Lets threads that have given a place back begin what may be early, one at a time, and nobody after the end.

    ``lock`` guards what is begun. Whoever comes again from within, because something was done at once, has no part.
    """

    def __init__(self, begin_all: Callable[[], None]):
        self.lock = threading.RLock()
        self._begin_all = begin_all
        self._is_busy = self._is_over = False

    def begin(self) -> None:
        """Begin what there is to begin."""
        with self.lock:
            if self._is_over or self._is_busy:
                return
            self._is_busy = True
            try:
                self._begin_all()
            finally:
                self._is_busy = False

    def end(self) -> None:
        """Begin no more."""
        with self.lock:
            self._is_over = True
