"""Draw the pictures that the pages show anew into docs/images: ``make images``.

A page's own commands are run as they stand; a picture that follows commands is the last one that these wrote. The
panels of the paper's figures are those in the folder that is named on the command line.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parent
ROOT, IMAGES = DOCS.parent, DOCS / "images"
PAGES = ("tutorial.md", "tutorial_events.md", "howto/explore.md")
# Panels that have another name in the documents.
RENAMED = {"fig4_1_diagram": "fig4_1", "fig4_2_diagram": "fig4_2", "fig4_4_phase": "fig4_4"}
PART = re.compile(
    r"^```(?P<kind>\w+)(?: title=\"(?P<title>[\w.]+)\")?\n(?P<text>.*?)^```$|^!\[[^]]*\]\((?P<image>\S+\.png)\)$",
    re.M | re.S,
)
WRITTEN = re.compile(r"^picture: (\S+\.png)$", re.M)


def draw_page(page: Path) -> None:
    """Run a page's commands in an empty folder, and keep the pictures that it shows after them."""
    with tempfile.TemporaryDirectory() as name:
        folder, last = Path(name), None
        for part in PART.finditer(page.read_text(encoding="utf-8")):
            if part["image"]:
                if last is not None:
                    shutil.copyfile(folder / last, page.parent / part["image"])
                    print(f"{page.name}: {Path(part['image']).name}")
                last = None
            elif part["title"]:
                with (folder / part["title"]).open("a", encoding="utf-8") as file:
                    file.write(part["text"])
            elif part["kind"] == "console":
                for command in re.findall(r"^\$ (.*)$", part["text"], re.M):
                    last = next(iter(WRITTEN.findall(run(command, folder))), last)


def run(command: str, folder: Path) -> str:
    """Return what a command of a page prints."""
    call = f'pddecont() {{ "{sys.executable}" -m pddecont "$@"; }}; {command}'
    done = subprocess.run(
        ["bash", "-c", call],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout + done.stderr


def copy_panels(folder: Path) -> None:
    """Copy the panels that the documents show."""
    for panel in sorted(folder.glob("*.png")):
        kept = IMAGES / f"{RENAMED.get(panel.stem, panel.stem)}.png"
        if kept.is_file():
            shutil.copyfile(panel, kept)
            print(kept.name)


if __name__ == "__main__":
    for page in PAGES:
        draw_page(DOCS / page)
    for folder in sys.argv[1:]:
        copy_panels(Path(folder))
