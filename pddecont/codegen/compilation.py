"""Compiling with settings of this program's own, which leave numba as it is for everybody else in the process."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba import config, njit
from numba.core import event, registry
from numba.core.compiler_lock import global_compiler_lock

from pddecont.codegen.announcement import announce_compilation

# The highest level of optimisation makes the integrator no faster and its compilation take half as long again.
OPTIMISATION = 2


@contextmanager
def compiler_settings(folder: Path | None) -> Iterator[None]:
    """Let numba compile as this program wants it, and keep what it compiles in ``folder`` (None: nowhere)."""
    # The target takes over what is set when it is first used: it is made as everybody else would make it.
    _ = registry.cpu_target.target_context
    settings: Any = config
    with global_compiler_lock:
        before = settings.CACHE_DIR, settings.OPT
        settings.CACHE_DIR = "" if folder is None else str(folder)
        if not os.environ.get("NUMBA_OPT"):
            settings.OPT = type(settings.OPT)(OPTIMISATION)
        try:
            yield
        finally:
            settings.CACHE_DIR, settings.OPT = before


class _Listener(event.Listener):
    """Passes on that numba begins to compile: what is read from disk does not come here."""

    def on_start(self, event: Any) -> None:
        announce_compilation()

    def on_end(self, event: Any) -> None:
        pass


def compile_when_called(function: Callable[..., Any], folder: Path | None) -> Any:
    """Return a function that numba compiles when it is first called, kept in ``folder`` (None: nowhere)."""
    with compiler_settings(folder):
        dispatcher: Any = njit(cache=folder is not None, nogil=True)(function)
    compile_it = dispatcher.compile

    def compile_here(signature: Any) -> Any:
        with compiler_settings(folder), event.install_listener("numba:compile", _Listener()):
            return compile_it(signature)

    dispatcher.compile = compile_here
    return dispatcher
