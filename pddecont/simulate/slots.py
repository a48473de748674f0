"""Who may compute: as many at once as there are workers, those whose turn it is before those that are early."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator


class Slots:
    """Places of those that compute at once; one of them is the seat of the thread that does all in order.

    ``on_free`` is called, by whoever gave it back, when a place is free.
    """

    def __init__(self, number: int):
        self.number = number
        self.on_free: Callable[[], None] = lambda: None
        self._taken = self._waiting = 0
        self._is_seated = False
        self._changed = threading.Condition()

    def take_early(self) -> bool:
        """Take a place if one is free that nobody waits for; return whether that was so."""
        with self._changed:
            is_free = self._taken < self.number and not self._waiting
            self._taken += is_free
        return is_free

    def give(self, number: int = 1) -> None:
        """Give places back."""
        with self._changed:
            self._taken -= number
            self._changed.notify_all()
        self.on_free()

    @contextlib.contextmanager
    def hold(self, number: int = 1) -> Iterator[None]:
        """Wait for places, and hold them."""
        self._take(number)
        try:
            yield
        finally:
            self.give(number)

    def sit(self) -> None:
        """Have the seat, to compute: wait for a place unless one sits already."""
        if not self._is_seated:
            self._take(1)
            self._is_seated = True

    def stand(self) -> None:
        """Leave the seat to others, to wait for them."""
        if self._is_seated:
            self._is_seated = False
            self.give()

    @contextlib.contextmanager
    def share(self) -> Iterator[None]:
        """Leave the seat to threads of one's own, which hold what places get free; nobody is early meanwhile."""
        with self._changed:
            self._waiting += 1
        try:
            self.stand()
            yield
        finally:
            with self._changed:
                self._waiting -= 1
            self.on_free()

    def _take(self, number: int) -> None:
        with self._changed:
            self._waiting += 1
            try:
                self._changed.wait_for(lambda: self._taken + number <= self.number)
                self._taken += number
            finally:
                self._waiting -= 1
