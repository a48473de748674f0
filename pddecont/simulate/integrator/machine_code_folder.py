"""Where the machine code of the integrator is kept between runs."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from pddecont.codegen import find_cache_folder


@cache
def find_machine_code() -> Path | None:
    """Return the folder that holds the machine code of the integrator as its sources are now; it may not exist yet.

    None if no folder can be written: then every process compiles it anew.
    """
    return find_cache_folder(Path(__file__).parent.glob("*.py"))
