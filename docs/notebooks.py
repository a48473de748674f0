"""What mkdocs does with docs/gallery: each notebook is run, and is a page with what it shows.

A notebook is a Python file whose cells begin with ``# %%``, as jupytext writes them; no outputs are kept in the
repository. Beside its page stands the same notebook, without outputs, to download.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jupytext
import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from nbclient import NotebookClient
from nbconvert import MarkdownExporter

GALLERY = Path(__file__).parent / "gallery"
# Seconds that a cell may take.
TIMEOUT = 300


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages, their pictures, and the notebooks without outputs."""
    for path in sorted(GALLERY.glob("*.py")):
        for name, contents in render_notebook(path).items():
            files.append(File.generated(config, f"gallery/{name}", content=contents))
    return files


def render_notebook(path: Path) -> dict[str, str | bytes]:
    """Return the page of a notebook that was run, its pictures and the notebook itself, by the names of their files."""
    book = jupytext.read(path)
    # The page of a notebook and the notebook are the same each time.
    for number, cell in enumerate(book.cells):
        cell.id = f"cell-{number}"
    empty = nbformat.writes(book)
    NotebookClient(book, timeout=TIMEOUT, kernel_name="python3").execute()
    resources: dict[str, Any] = {"unique_key": path.stem, "output_files_dir": f"{path.stem}_files"}
    text, found = MarkdownExporter().from_notebook_node(book, resources)
    link = f"[This page as a notebook]({path.stem}.ipynb); it was run when these pages were built.\n"
    return {f"{path.stem}.md": f"{text}\n{link}", f"{path.stem}.ipynb": empty, **found["outputs"]}
