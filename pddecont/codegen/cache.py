"""Where machine code is kept between runs."""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import tempfile
from collections.abc import Iterable
from functools import cache
from pathlib import Path


def choose_cache_folder(sources: Iterable[Path]) -> Path:
    """Return the folder for what is compiled from ``sources``, another one for every state of them.

    numba looks only at the file that a function is in, not at those that it calls: a folder for each state of all of
    them keeps old machine code from new sources. The environment variables NUMBA_CACHE_DIR and XDG_CACHE_HOME move it.
    """
    digest = hashlib.sha256(importlib.metadata.version("numba").encode())
    for source in sorted(sources):
        digest.update(source.read_bytes())
    return _find_base() / digest.hexdigest()[:16]


def find_cache_folder(sources: Iterable[Path]) -> Path | None:
    """Return a folder that can be written for what is compiled from ``sources``; None if there is none.

    It is the one that :func:`choose_cache_folder` names, or else one of this user's own among temporary files.
    """
    wanted = choose_cache_folder(sources)
    for base in (wanted.parent, _name_temporary_base()):
        if can_be_written(base):
            return base / wanted.name
    return None


def describe_cache_failure() -> str:
    """Return what to tell a person whose machine code cannot be kept where it should be; empty if it can."""
    base, other = _find_base(), _name_temporary_base()
    if can_be_written(base):
        return ""
    instead = f"it is kept in {other} instead" if can_be_written(other) else "every run compiles it anew, for a minute"
    return (
        f"machine code cannot be kept in {base}, which cannot be written: {instead}. To keep it elsewhere, set "
        "NUMBA_CACHE_DIR to a folder that can be written"
    )


def _find_base() -> Path:
    own = os.environ.get("NUMBA_CACHE_DIR")
    if own:
        return Path(own)
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        # No home folder is known: containers, service accounts.
        return _name_temporary_base()
    return home / "pddecont"


def _name_temporary_base() -> Path:
    return Path(tempfile.gettempdir()) / f"pddecont-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"


@cache
def can_be_written(folder: Path) -> bool:
    """Return whether a folder exists, or can be made, where this user and nobody else puts machine code."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        # What is in a folder of somebody else would be run as it is.
        return folder != _name_temporary_base() or _is_own(folder)
    except OSError:
        return False


def _is_own(folder: Path) -> bool:
    about = folder.lstat()
    return not hasattr(os, "getuid") or (about.st_uid == os.getuid() and about.st_mode & 0o777 == 0o700)
