"""Ctrl-C and SIGTERM: the program ends soon, wherever it is, and says with which code.

A signal first becomes an exception, so that files are closed as always. Machine code does not look for exceptions, and
a worker in the middle of a long motion is not waited for: if the program still runs after a while, or at a second
signal, it ends on the spot. Nothing is lost by that, as a results file is in order at every instant. A signal that
comes when the work is done changes nothing: the program ends with the code of what it did.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import FrameType
from typing import Any

# How long the program is given to end by itself, in seconds.
GRACE = 2.0
# To a terminal: the line of progress that was moving is cleared, and the cursor shown again.
CLEAR_LINE = "\r\x1b[K\x1b[?25h"
MESSAGE = "interrupted; what was finished is kept, and 'run' with --resume goes on from there"


@dataclass
class Received:
    """The first signal that came (0: none yet), whether a person has been told, and whether the work is over."""

    number: int = 0
    told: bool = False
    over: bool = False

    @property
    def code(self) -> int:
        """The exit code: 130 for Ctrl-C, 143 for SIGTERM."""
        return 128 + (self.number or signal.SIGINT)

    def tell(self) -> None:
        """Say, once, what has happened."""
        if not self.told:
            self.told = True
            with contextlib.suppress(OSError, ValueError):
                sys.stderr.write(f"{CLEAR_LINE if sys.stderr.isatty() else ''}{MESSAGE}\n")
                sys.stderr.flush()


@contextlib.contextmanager
def end_on_signals(*, ends_process: bool = False) -> Iterator[Received]:
    """Turn signals into KeyboardInterrupt, and see to it that the program ends after one.

    Where the process ends with the work (``ends_process``), signals that come later are ignored; otherwise they do what
    they did before.
    """
    received = Received()
    if threading.current_thread() is not threading.main_thread():
        yield received
        return

    def interrupt(number: int, _: FrameType | None) -> None:
        if not received.number and not received.over:
            received.number = number
            raise KeyboardInterrupt

    ends, write = os.pipe()
    os.set_blocking(write, False)
    before = {
        n: signal.signal(n, interrupt)
        for n in (signal.SIGINT, signal.SIGTERM)
        if signal.getsignal(n) is not signal.SIG_IGN
    }
    wakeup = signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    unraisable, sys.unraisablehook = sys.unraisablehook, _quiet(sys.unraisablehook)
    threading.Thread(target=_watch, args=(ends, received), daemon=True).start()
    try:
        try:
            yield received
        finally:
            received.over = True
    except KeyboardInterrupt:
        if received.number:
            # Everything is closed; Python itself would wait for workers, and may end by a signal of its own instead of
            # with a code.
            _end(received.number, received)
        received.tell()
        sys.exit(received.code)
    finally:
        # After a signal the watch goes on until the process has ended, while the interpreter waits for workers too.
        if not received.number:
            signal.set_wakeup_fd(wakeup)
            sys.unraisablehook = unraisable
            for number, handler in before.items():
                signal.signal(number, signal.SIG_IGN if ends_process else handler)
            os.close(write)


def _quiet(hook: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a hook that says nothing of an interruption that came where none can be raised.

    The watch ends the program.
    """
    return lambda lost: None if isinstance(lost.exc_value, KeyboardInterrupt) else hook(lost)


def _watch(ends: int, received: Received) -> None:
    """End the process some time after the first signal, or at the second."""
    first = os.read(ends, 1)
    if first:
        timer = threading.Timer(GRACE, _end, (first[0], received))
        timer.daemon = True
        timer.start()
        if os.read(ends, 1):
            _end(first[0], received)
    os.close(ends)


def _end(number: int, received: Received) -> None:
    received.number = number
    received.tell()
    os._exit(received.code)
