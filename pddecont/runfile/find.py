"""Files by path, or by the name of a model or run that ships with the program."""

from __future__ import annotations

from pathlib import Path

from pddecont.data import list_shipped
from pddecont.errors import RunError, suggest

# Letters of a name that a message repeats.
MAX_SHOWN = 100


def find_file(name: str, base: Path | None = None) -> Path:
    """Return the file that ``name`` means: a path (relative to ``base``), else a shipped model or run.

    A path without a base, given by a person, may be a pipe, as the shell's ``<(...)`` is.

    Raises
    ------
    RunError
        If there is no such file, with the nearest name.
    """
    path = Path(name) if base is None else base / name
    try:
        if path.is_file() or (base is None and path.is_fifo()):
            return path
        if path.is_dir():
            raise RunError.at(name, 0, 0, "is a folder; expected a YAML file")
    except (OSError, ValueError) as exc:
        raise RunError.at(
            name[:MAX_SHOWN], 0, 0, f"cannot be the name of a file: {getattr(exc, 'strerror', exc)}"
        ) from exc
    shipped = list_shipped()
    stem = name.removesuffix(".yaml")
    if stem in shipped:
        return shipped[stem]
    hint = suggest(name, shipped) or f" (shipped: {', '.join(sorted(shipped))})"
    raise RunError.at(name, 0, 0, f"does not exist, and no shipped model or run has this name{hint}")


def name_file(path: Path) -> str:
    """Return what means the file at ``path`` from every folder: a shipped one's name, else its whole path."""
    shipped = list_shipped().get(path.stem)
    return path.stem if shipped is not None and shipped.resolve() == path.resolve() else str(path.resolve())
