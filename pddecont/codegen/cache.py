"""Where machine code is kept between runs."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

# The highest level of optimisation makes the integrator no faster and its compilation take half as long again.
os.environ.setdefault("NUMBA_OPT", "2")

import numba


def choose_cache_folder(sources: Iterable[Path]) -> Path:
    """Return the folder for what is compiled from ``sources``, another one for every state of them.

    numba looks only at the file that a function is in, not at those that it calls: a folder for each state of all of
    them keeps old machine code from new sources. The environment variables NUMBA_CACHE_DIR and XDG_CACHE_HOME move it.
    """
    own = os.environ.get("NUMBA_CACHE_DIR")
    base = Path(own) if own else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "pddecont"
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(sources):
        digest.update(source.read_bytes())
    return base / digest.hexdigest()[:16]
