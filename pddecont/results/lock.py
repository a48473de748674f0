"""One run at a time writes a results file.

A run holds the system's advisory lock on a file beside the results file. The system lets go of it when the process
ends, however that happens, so that a file left behind by a killed run stands in nobody's way.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from pddecont.errors import ResultsError


@contextlib.contextmanager
def hold_lock(path: Path) -> Iterator[None]:
    """Hold the right to write the results file at ``path``; raise :class:`ResultsError` if another run holds it."""
    if path.exists() and not path.is_file():
        raise ResultsError(f"{path} is not a file that can hold results; give another -o")
    lock = path.with_name(f".{path.name}.lock")
    try:
        descriptor = _take(lock)
    except BlockingIOError as exc:
        raise ResultsError(
            f"{path} is being written by another run (process {_holder(lock)}); wait until it ends, or give another -o"
        ) from exc
    except OSError as exc:
        raise ResultsError(f"{path} cannot be written: {exc.strerror}; check the folder") from exc
    try:
        # What a killed run was about to put in the file's place.
        part_of(path).unlink(missing_ok=True)
        yield
    finally:
        # Removed while it is held, so that no one can hold a lock on a file that has lost its name and believe to be
        # alone.
        lock.unlink(missing_ok=True)
        os.close(descriptor)


def part_of(path: Path) -> Path:
    """Return where a results file is written anew before it takes the old one's place."""
    return path.with_name(f".{path.name}.part")


def _take(lock: Path) -> int:
    """Return the descriptor of the lock file, locked; raise BlockingIOError if someone else has it."""
    while True:
        descriptor = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(descriptor), os.stat(lock)):
                os.ftruncate(descriptor, 0)
                with contextlib.suppress(OSError):  # a full disk: the number is only for a message
                    os.pwrite(descriptor, str(os.getpid()).encode(), 0)
                return descriptor
        except FileNotFoundError:
            pass  # the one who held it removed it just now: try anew
        except OSError:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _holder(lock: Path) -> str:
    with contextlib.suppress(OSError):
        return lock.read_text() or "unknown"
    return "unknown"


def check_unlocked(path: Path) -> None:
    """Raise :class:`ResultsError` if another program has the file open and locked, as HDF5 does while it writes."""
    try:
        with path.open("rb") as stream:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError as exc:
        raise ResultsError(f"{path} is locked by another program; close it there, or give another -o") from exc
    except OSError as exc:
        raise ResultsError(f"{path} cannot be read: {exc.strerror}; check the file") from exc
