"""What the README and the docs show is run as written.

A page is one session in an empty folder. ```` ```yaml title="FILE" ```` writes a file, further blocks of the same title
go on with it; ```` ```console ```` runs what stands after ``$ `` and looks for the lines below it in what was printed
(``...`` stands for anything); ```` ```python ```` is run.
"""

import importlib.util
import os
import re
import shlex
import subprocess
import sys

import numpy as np
import pytest
import yaml
from scipy.optimize import fsolve

from pddecont.cli import COMMANDS
from pddecont.results import BASIN, CONTINUE, EXPLORE, ORBIT, PRECISION, SIMULATE, SWEEP, read_results
from pddecont.results.format import FORMAT_VERSION
from tests.cli.test_cli import call
from tests.conftest import MODELS, ROOT

DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
SESSIONS = [
    ROOT / "README.md",
    DOCS / "tutorial.md",
    DOCS / "tutorial_events.md",
    DOCS / "pictures.md",
    DOCS / "architecture.md",
]
SESSIONS += sorted((DOCS / "howto").glob("*.md"))
BLOCK = re.compile(r"^```(\w+)(?: title=\"([\w.]+)\")?\n(.*?)^```$", re.M | re.S)
NEEDS_SHELL = re.compile(r"[|<>;&$*]")


def name_of(path):
    return str(path.relative_to(ROOT))


@pytest.fixture
def session(in_folder, monkeypatch):
    """A function that runs a page; ``pddecont`` in its shell is this working copy's."""
    program = in_folder / "bin" / "pddecont"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m pddecont "$@"\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))

    def run(page):
        for kind, title, text in BLOCK.findall(page.read_text()):
            if title:
                with open(title, "a") as file:
                    file.write(text)
            elif kind == "console":
                run_console(text)
            elif kind == "python":
                printed([sys.executable, "-W", "error", "-c", text])

    return run


def run_console(text):
    for part in re.split(r"^\$ ", text, flags=re.M)[1:]:
        command, *expected = part.splitlines()
        output = printed(command)
        for line in expected:
            pattern = ".*".join(re.escape(piece) for piece in line.split("..."))
            assert re.search(pattern, output), f"{command}\nprinted\n{output}\nbut not\n{line}"


def printed(command):
    """Return what a command prints on both channels; it must succeed."""
    if isinstance(command, str) and not NEEDS_SHELL.search(command):
        first, *words = shlex.split(command)
        assert first == "pddecont"
        code, out, err = call(*words)
        output = out + err
    else:
        words = ["bash", "-o", "pipefail", "-c", command] if isinstance(command, str) else command
        done = subprocess.run(words, capture_output=True, text=True, timeout=300)
        code, output = done.returncode, done.stdout + done.stderr
    assert code == 0, f"{command}\n{output}"
    return output


@pytest.mark.parametrize("page", SESSIONS, ids=name_of)
def test_a_page_runs_from_top_to_bottom(page, session):
    session(page)


@pytest.mark.slow
def test_the_readmes_commands_run(in_folder):
    for name in ("configs", "models"):
        (in_folder / name).symlink_to(ROOT / name)
    for line in re.findall(r"^    (pddecont [^#\n]*)", (ROOT / "README.md").read_text(), re.M):
        printed(line)


def test_the_first_tutorials_numbers_have_their_closed_form():
    """Rest solves c (1 - x^2) = x; with s = 2 c x a pair i w has w^2 = s^2 - 1 and cos(w tau) = -1/s."""
    text = (DOCS / "tutorial.md").read_text()
    rest = (np.sqrt(17.0) - 1.0) / 4.0
    slope = 4.0 * rest
    frequency = np.sqrt(slope**2 - 1.0)
    exact = (np.arccos(-1.0 / slope) + 2.0 * np.pi * np.arange(2)) / frequency
    (stated,) = re.findall(r"^rest: x = ([\d.]+) in mode", text, re.M)
    assert float(stated) == pytest.approx(rest, abs=1e-10)
    printed_ = re.findall(r"^\d+,HB\d,HB,x_above,2.0,([\d.]+)\.\.\.", text, re.M)
    assert [float(tau) for tau in printed_] == pytest.approx(exact, abs=1e-10)
    (stated,) = re.findall(r"which gives tau = ([\d.]+);", text)
    assert float(stated) == pytest.approx(exact[0], abs=1e-12)


def test_the_tutorials_grazing_has_its_closed_form():
    """The numbers that the tutorial states: the linear orbit's amplitude is a / |1 - w^2 + i w (c + K (1 - exp(-i w
    tau)))|.
    """
    text = (DOCS / "tutorial_events.md").read_text()
    w, c, damping, tau = 1.3, 0.05, 0.1, 1.0
    exact = abs(1 - w**2 + 1j * w * (c + damping * (1 - np.exp(-1j * w * tau))))
    (stated,) = re.findall(r"^([\d.]+); the program found it", text, re.M)
    assert float(stated) == pytest.approx(exact, abs=1e-10)
    (printed_,) = re.findall(r"^31,GR1,GR,1.3,([\d.]+)\.\.\.", text, re.M)
    assert float(printed_) == pytest.approx(exact, abs=1e-8)


def test_the_tutorials_hopf_points_have_their_closed_form():
    """They solve w^2 - 1 = +-w sqrt(K^2 - c^2) with cos(w tau) = -c/K; with the plus pairs come to be unstable."""
    text = (DOCS / "tutorial_events.md").read_text()
    c, damping = 0.05, 0.3
    late = np.sqrt(damping**2 - c**2)
    up, down = (np.sqrt(1.0 + late**2 / 4.0) + sign * late / 2.0 for sign in (1, -1))
    angle = np.arccos(-c / damping)
    exact = [angle / up, (2 * np.pi - angle) / down, (2 * np.pi + angle) / up]
    printed_ = re.findall(r"^\d+,HB\d,HB,stop_below,0.05,1.0,10.0,0.3,([\d.]+)\.\.\.", text, re.M)
    assert [float(tau) for tau in printed_] == pytest.approx(exact, abs=1e-10)
    (stated,) = re.findall(r"so tau =\n([\d.]+)\. From there", text)
    assert float(stated) == pytest.approx(exact[0], abs=1e-12)


def test_the_neurons_hopf_points_have_the_numbers_of_their_page():
    """Rest has the roots of (l + 1/2 + exp(-l taus))^2 = a21 exp(-0.4 l)."""

    def miss(unknown, guess):
        def equations(x):
            a21, taus = (x[1], 1.5) if unknown == "a21" else (0.207, x[1])
            z = 1j * x[0]
            value = (z + 0.5 + np.exp(-z * taus)) ** 2 - a21 * np.exp(-0.4 * z)
            return [value.real, value.imag]

        return fsolve(equations, guess, xtol=1e-12)

    text = (DOCS / "howto" / "from_dde_biftool.md").read_text()
    stated = [float(v) for v in re.findall(r"^\| .* \| [\d.]+ \| ([\d.]+) \|$", text, re.M)]
    (frequency, a21), (other, taus) = miss("a21", [0.78, 0.8]), miss("taus", [0.91, 8.63])
    assert stated == pytest.approx([a21, frequency, taus, other], abs=1e-10)
    # The root 0 is double there: with f the left side less the right one, f(0) = 0 and f'(0) = 0.
    assert (1 / 2 + 1) ** 2 == 2.25
    assert pytest.approx(-0.4 * 2.25) == 2 * (1 / 2 + 1) * (1 - 1.3)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_model_and_run_on_a_page_is_run(page):
    for kind, title, text in BLOCK.findall(page.read_text()):
        assert not title or page in SESSIONS
        if kind == "yaml" and not title:
            assert not {"states", "steps", "model"} & set(yaml.safe_load(text)), f"{page}: a whole file without a title"


@pytest.mark.parametrize("page", [p for p in PAGES if p.parent.name != "reference"], ids=name_of)
def test_commands_on_a_page_are_commands_with_such_options(page):
    lines = re.findall(r"^(?:    |\$ )pddecont ([^\n]*?)(?:\s+[#|>].*)?$", page.read_text(), re.M)
    for line in lines:
        name, *rest = shlex.split(line)
        assert name in COMMANDS
        usage = call(name, "--help")[1]
        for option in (w for w in rest if w.startswith("-")):
            assert option in usage


def test_every_command_and_option_is_in_the_reference():
    for page, text in generated().items():
        assert (DOCS / "reference" / page).read_text() == text, "run 'make reference'"


def script(name):
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def generated():
    return script("generate").pages()


def test_every_door_is_in_the_python_reference():
    doors = {".".join(path.parent.relative_to(ROOT).parts) for path in (ROOT / "pddecont").rglob("__init__.pyi")}
    page = (DOCS / "reference" / "python_api.md").read_text()
    named = re.findall(r"^::: ([\w.]+)$", page, re.M)
    assert named[:3] == ["pddecont.api", "pddecont.errors", "pddecont.reasons"]
    assert doors <= {*named}


def test_every_folder_is_in_the_picture_of_layers_and_in_the_list():
    layers = script("layers")
    drawn = layers.find_layers(layers.read_imports())
    folders = {path.parent.name for path in (ROOT / "pddecont").glob("*/__init__.py")}
    assert folders <= {*drawn} <= {*folders, *layers.OWN}
    listed = re.findall(r"^\| `([\w/]+)` \|", (DOCS / "architecture.md").read_text(), re.M)
    assert sorted(listed) == sorted(name.replace(".", "/") for name in drawn)


@pytest.mark.parametrize(
    "step_format", [SIMULATE, ORBIT, CONTINUE, SWEEP, BASIN, PRECISION, EXPLORE], ids=lambda f: f.kind
)
def test_every_column_of_results_files_is_described(step_format):
    page = (DOCS / "results.md").read_text()
    assert f"HDF5, format {FORMAT_VERSION}." in page
    assert not [name for name in (*step_format.points, *step_format.orbits) if f"`{name}`" not in page]


def test_every_page_is_in_the_sites_navigation():
    def files(item):
        if isinstance(item, str):
            return [item]
        return [file for part in (item.values() if isinstance(item, dict) else item) for file in files(part)]

    listed = files(yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"])
    notebooks = [f"gallery/{path.stem}.md" for path in (DOCS / "gallery").glob("*.py")]
    assert sorted(listed) == sorted([*(str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md")), *notebooks])


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_every_model_runs_its_own_run_to_the_first_orbit(path, in_folder):
    has_orbit = "name: orbit," in path.read_text()
    code, _, err = call("run", path, "-q", *(("--until", "orbit") if has_orbit else ()))
    assert code == 0, err
    if not has_orbit:
        assert call("plot", f"{path.stem}.h5")[0] == 0
        return
    step = read_results(f"{path.stem}.h5").step("orbit")
    assert step.points["error_estimate"][0] < 1e-6
    assert step.points["admissible"][0] == 1
    assert call("plot", f"{path.stem}.h5")[0] == 0


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_documents_name_files_that_exist(page):
    for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
        # The page of a notebook is made when the site is.
        source = target.replace(".md", ".py") if "gallery/" in target else target
        assert (page.parent / source).exists(), (page, target)
    for target in re.findall(r"`((?:tests|configs|models|benchmarks|pddecont)/[\w/.]+)`", page.read_text()):
        assert (ROOT / target).exists(), (page, target)
