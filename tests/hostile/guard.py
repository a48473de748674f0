"""What an input from a stranger may not do, watched while it is read."""

from __future__ import annotations

import contextlib
import os
import signal
import sys

import mpmath
import sympy

# What Python reports of itself when code is run, processes are started, files are changed or the network is used.
FORBIDDEN = (
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "os.spawn",
    "os.fork",
    "os.remove",
    "os.rename",
    "os.mkdir",
    "os.rmdir",
    "os.chmod",
    "os.link",
    "os.symlink",
    "os.truncate",
    "subprocess.Popen",
    "socket.",
    "ctypes.dlopen",
    "shutil.",
    "urllib.Request",
    "import",
    "pickle.find_class",
)
# These load parts of themselves when they are first needed.
LIBRARIES = tuple(f"{os.path.dirname(library.__file__)}{os.sep}" for library in (sympy, mpmath))
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT
_watch = {"on": False}
_seen: list[str] = []


def _hear(event, args):
    if not _watch["on"]:
        return
    if event == "open" and not (isinstance(args[1], str) and set(args[1]) <= set("rbt")) and args[2] & WRITES:
        _seen.append(f"open {args}")
    elif event == "exec" and not getattr(args[0], "co_filename", "").startswith(("<generated>", *LIBRARIES)):
        _seen.append(f"exec {args}")
    elif event == "import" and args[0].startswith(("sympy", "mpmath")):
        return
    elif event.startswith(FORBIDDEN):
        _seen.append(f"{event} {args}")


sys.addaudithook(_hear)


class TooLong(BaseException):
    """An input took longer than it may."""


@contextlib.contextmanager
def watched(seconds):
    """Watch what is done inside; raise if it takes too long or does what no input may do."""

    def late(*_):
        raise TooLong

    before = signal.signal(signal.SIGALRM, late)
    _seen.clear()
    signal.setitimer(signal.ITIMER_REAL, seconds)
    _watch["on"] = True
    try:
        yield
    finally:
        _watch["on"] = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert not _seen, _seen[:3]
