"""The integrator's compiled part: functions of arrays and numbers that numba turns into machine code.

What is compiled is kept in the user's cache folder, apart for every state of these sources: numba looks only at the file that a
function stands in, not at those that it calls, so that a folder for each is what keeps old machine code from new sources.
"""

from __future__ import annotations

import hashlib
import os
from functools import cache
from pathlib import Path

# The highest level of optimisation makes the integrator no faster and its compilation half as long again.
os.environ.setdefault("NUMBA_OPT", "2")

import numba


@cache
def cache_folder() -> Path:
    """Return the folder that holds what was compiled from these sources; environment variables of numba and XDG move it."""
    base = os.environ.get("NUMBA_CACHE_DIR") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "pddecont"
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return Path(base) / digest.hexdigest()[:16]


# Where a function is kept is decided when it is decorated, so this comes before the other files of this folder are read.
numba.config.CACHE_DIR = str(cache_folder())
