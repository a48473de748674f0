"""Files by path, or by the name of a model or run that ships with the program."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from pddecont.errors import RunError, suggest

SUFFIX = ".yaml"
# Letters of a name that a message repeats.
MAX_SHOWN = 100


def folders() -> list[Path]:
    """Return the folders that shipped models and runs lie in, models first."""
    result = []
    for name in ("models", "configs"):
        spec = importlib.util.find_spec(f"pddecont.shipped.{name}")
        installed = [Path(p) for p in (spec.submodule_search_locations or [])] if spec else []
        beside = Path(__file__).parents[2] / name
        result += [folder for folder in (*installed, beside) if folder.is_dir()][:1]
    return result


def find(name: str, base: Path | None = None) -> Path:
    """Return the file that ``name`` means: a path (relative to ``base``), else a shipped model or run.

    Raises
    ------
    RunError
        If there is no such file, with the nearest name.
    """
    path = Path(name) if base is None else base / name
    try:
        if path.is_file():
            return path
        if path.is_dir():
            raise RunError.at(name, 0, 0, "is a folder; expected a YAML file")
    except (OSError, ValueError) as exc:
        raise RunError.at(name[:MAX_SHOWN], 0, 0, f"cannot be the name of a file: {getattr(exc, 'strerror', exc)}") from exc
    shipped = {file.stem: file for folder in reversed(folders()) for file in folder.glob(f"*{SUFFIX}")}
    if name.removesuffix(SUFFIX) in shipped:
        return shipped[name.removesuffix(SUFFIX)]
    hint = suggest(name, shipped) or f" (shipped: {', '.join(sorted(shipped))})"
    raise RunError.at(name, 0, 0, f"does not exist, and no shipped model or run has this name{hint}")
