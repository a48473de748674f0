"""Models with comments that new ones start from."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from pddecont.errors import ModelError

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")


def write_starter(kind: str, name: str, path: Path) -> None:
    """Write the starter of a kind to a file that does not exist yet.

    Raises
    ------
    ModelError
        If ``name`` is no name, or the file exists or cannot be written.
    """
    if not _NAME.fullmatch(name):
        raise ModelError.at(
            name,
            0,
            0,
            "is not a name for a model: letters, digits, _ and -, not starting with a digit; give the file with -o",
        )
    text = files("pddecont.data.starters").joinpath(f"{kind}.yaml").read_text(encoding="utf-8")
    try:
        with path.open("x", encoding="utf-8") as stream:
            stream.write(text.replace("name: starter\n", f"name: {name}\n", 1))
    except FileExistsError as exc:
        raise ModelError.at(str(path), 0, 0, "exists already and is left as it is; give another name, or -o") from exc
    except OSError as exc:
        raise ModelError.at(str(path), 0, 0, f"cannot be written: {exc.strerror}") from exc
