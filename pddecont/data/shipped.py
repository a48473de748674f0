"""Models and run files that come with the program."""

from __future__ import annotations

import importlib.util
import itertools
import re
from pathlib import Path

_END_OF_SENTENCE = re.compile(r"\.\s+(?=[A-Z])")


def find_shipped_folders() -> list[Path]:
    """Return the folders that shipped models and runs lie in, models first."""
    result = []
    for name in ("models", "configs"):
        spec = importlib.util.find_spec(f"pddecont.data.{name}")
        installed = [Path(p) for p in (spec.submodule_search_locations or [])] if spec else []
        beside = Path(__file__).parents[2] / name
        result += [folder for folder in (*installed, beside) if folder.is_dir()][:1]
    return result


def list_shipped() -> dict[str, Path]:
    """Return shipped models and runs by name; where both have one name it is the model's."""
    return {file.stem: file for folder in reversed(find_shipped_folders()) for file in folder.glob("*.yaml")}


def describe_shipped(file: Path) -> str:
    """Return what a shipped file says of itself in one line: the first sentence of the comment that it begins with."""
    comment = itertools.takewhile(lambda line: line.startswith("#"), file.read_text(encoding="utf-8").splitlines())
    text = " ".join(line.lstrip("# ").rstrip() for line in comment)
    sentence, *_ = _END_OF_SENTENCE.split(text, maxsplit=1)
    return sentence.rstrip(".")
