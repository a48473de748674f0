"""The notebooks of the docs and the examples of docs/python.md: their types are right, and they run.

``docs/notebooks.py`` makes pages of the notebooks; here they are run as what they are, Python.
"""

import re
import subprocess
import sys

import pytest

from tests.conftest import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "gallery").glob("*.py"))
EXAMPLES = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(), re.S)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, in_folder):
    exec(compile(path.read_text(), str(path), "exec"), {"__name__": path.stem})
    assert not list(in_folder.iterdir())


def test_there_are_notebooks_and_examples():
    assert len(NOTEBOOKS) >= 4
    assert len(EXAMPLES) >= 2


def check_types(folder, *paths):
    """Return what mypy says of files with its strictest settings, as one who uses the package would."""
    words = [
        "--strict",
        "--cache-dir",
        str(ROOT / ".mypy_cache" / "examples"),
        "--ignore-missing-imports",
        "--follow-imports",
        "silent",
    ]
    return subprocess.run(
        [sys.executable, "-m", "mypy", *words, *map(str, paths)],
        capture_output=True,
        text=True,
        cwd=folder,
        env={"MYPYPATH": str(ROOT), "PATH": ""},
    )


def test_types_of_all_examples_are_right(tmp_path):
    for number, text in enumerate(EXAMPLES):
        (tmp_path / f"example_{number}.py").write_text(text)
    done = check_types(tmp_path, *NOTEBOOKS, *tmp_path.glob("*.py"))
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_is_misspelt_is_seen(tmp_path):
    (tmp_path / "wrong.py").write_text(
        "import pddecont\n"
        "results = pddecont.run('relay', monitor={})\n"
        "results['orbit'].orbits()\n"
        "text: str = results['orbit'].point().parameters['a']\n"
    )
    done = check_types(tmp_path, tmp_path / "wrong.py")
    lines = re.findall(r"wrong\.py:(\d): error", done.stdout)
    assert lines == ["2", "3", "4"], done.stdout
