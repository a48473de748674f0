"""Who hears that machine code is made, which takes a while; the compiler itself is not imported for that."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

# The latest comes first.
_listeners: list[Callable[[], None]] = []


@contextmanager
def tell_compilation(listener: Callable[[], None]) -> Iterator[None]:
    """Call ``listener`` once if :func:`announce_compilation` is called meanwhile."""
    told: list[bool] = []

    def tell() -> None:
        if not told:
            told.append(True)
            listener()

    _listeners.append(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)


def announce_compilation() -> None:
    """Tell who listens that something is compiled anew."""
    if _listeners:
        _listeners[-1]()
