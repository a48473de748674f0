"""Explore every shipped model over the range of its own first branch, and make a gallery: ``make atlas``.

Results and pictures lie in the folder that is named; what is there is gone on with, or left if it is done. With
``--docs`` the gallery of the documents, docs/atlas.md, is written of them.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import yaml
from PIL import Image

from pddecont.data import describe_shipped, find_shipped_folders
from pddecont.errors import PddecontError
from pddecont.results import read_results
from pddecont.tables import describe_endings

DOCS = Path(__file__).parent
IMAGES = DOCS / "images" / "atlas"
# Once the budget is spent a motion or a step that is under way ends; it is waited for so many seconds more.
GRACE = 120.0
# Of a picture in the documents, in pixels.
WIDTH = 900
INTRODUCTION = """\
# Atlas

Every model that comes with the program and has a branch of its own, explored over the range of that branch by one
command: `pddecont explore MODEL --over NAME=LOW:HIGH --time {seconds:g}`; `make atlas` makes this page anew
(`make atlas SECONDS=600` with more time). Grey circles are motions that settled, crosses those that lie on no branch.
The sentence is the program's own: of the motions that were simulated at the end, from other places than those that the
branches started from, how many lie on stable branches, and what the others are. Where the time was over, it says so
last.
"""


def list_ranges() -> dict[str, dict[str, list[float]]]:
    """Return a parameter and its range of each model: those of its first branch in one parameter."""
    found = {}
    for path in sorted(find_shipped_folders()[0].glob("*.yaml")):
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        branches = [step["continue"] for step in (data.get("run") or {}).get("steps", []) if "continue" in step]
        alone = [branch for branch in branches if len(branch["free"]) == 1]
        if alone:
            (name,) = alone[0]["free"]
            found[path.stem] = {name: alone[0]["range"][name]}
    return found


def explore(name: str, over: dict[str, list[float]], folder: Path, seconds: float, workers: int) -> None:
    """Explore a model into a file, or go on with it."""
    file = folder / f"{name}.h5"
    ranges = [f"--over={key}={low}:{high}" for key, (low, high) in over.items()]
    how = ["--resume"] if file.exists() else []
    if not is_done(file):
        words = ["explore", name, *ranges, "-o", str(file), f"--time={seconds:g}", f"--workers={workers}", "-q", *how]
        try:
            call(words, seconds + GRACE)
        except subprocess.TimeoutExpired:
            print(f"{name}: took longer than {seconds + GRACE:g} s", flush=True)


def draw(name: str, folder: Path) -> None:
    """Draw an exploration, if there is one."""
    file = folder / f"{name}.h5"
    if "explore" in read_results(file).steps:
        call(["plot", str(file), "--view", "explore", "-o", str(folder / f"{name}.png"), "--size", "120mm"], GRACE)


def shrink(picture: Path, kept: Path) -> None:
    """Keep a picture as narrow as a page, in few colours."""
    with Image.open(picture) as image:
        size = (WIDTH, round(image.height * WIDTH / image.width))
        image.convert("RGB").resize(size, Image.Resampling.LANCZOS).quantize(48, dither=Image.Dither.NONE).save(
            kept, optimize=True
        )


def is_done(file: Path) -> bool:
    """Return whether an exploration ended by itself, not because its time was over."""
    try:
        (ending,) = read_results(file).step("explore").endings
    except (PddecontError, ValueError):
        return False
    return bool(ending.values["stopped"] != "time")


def call(words: list[str], seconds: float) -> None:
    """Run a command of this program; what it says goes to the terminal."""
    subprocess.run([sys.executable, "-m", "pddecont", *words], check=False, timeout=seconds)


def describe(name: str, over: dict[str, list[float]], folder: Path) -> str:
    """Return what the gallery says of a model, as Markdown."""
    path = find_shipped_folders()[0] / f"{name}.yaml"
    ranges = ", ".join(f"`{key}` from {low} to {high}" for key, (low, high) in over.items())
    head = f"## {name}\n\n{describe_shipped(path)}. Over {ranges}."
    step = read_results(folder / f"{name}.h5").steps.get("explore")
    if step is None or not len(step):
        return f"{head}\n\nNot explored to an end in the time: a motion or a step along a branch takes longer."
    text = "; ".join(describe_endings(step)) or "The time was over before it ended"
    return f"{head}\n\n{text}\n\n![{name}: all branches that were found](images/atlas/{name}.png)"


def main() -> None:
    """Do what this module's docstring says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--draw", action="store_true", help="draw what is there, and compute nothing")
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--only", action="append", help="a model; may be repeated")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    ranges = {name: over for name, over in list_ranges().items() if not given.only or name in given.only}
    for name, over in ranges.items():
        if not given.draw:
            explore(name, over, given.folder, given.seconds, given.workers)
        draw(name, given.folder)
        print(f"{name}: done", flush=True)
    if given.docs:
        IMAGES.mkdir(exist_ok=True)
        for name in ranges:
            if (given.folder / f"{name}.png").exists():
                shrink(given.folder / f"{name}.png", IMAGES / f"{name}.png")
        parts = [INTRODUCTION.format(seconds=given.seconds).rstrip()]
        parts += [describe(name, over, given.folder) for name, over in ranges.items()]
        (DOCS / "atlas.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
