"""What a release is made of agrees with itself: metadata, recipes, citation, archive."""

import importlib.util
import re
import sys
import tomllib
from unittest import mock

import pytest
import yaml

import pddecont
from tests.conftest import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
BUILD = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]
# Names at conda-forge that differ from those at PyPI.
RENAMED = {"matplotlib": "matplotlib-base"}


def load_setup():
    """Return the module setup.py, whose call to setup does nothing."""
    spec = importlib.util.spec_from_file_location("project_setup", ROOT / "setup.py")
    module = importlib.util.module_from_spec(spec)
    with mock.patch("setuptools.setup"), mock.patch.dict(sys.modules), mock.patch("pathlib.Path.write_text"):
        spec.loader.exec_module(module)
    return module


@pytest.fixture
def described(monkeypatch):
    monkeypatch.chdir(ROOT)
    pytest.importorskip("setuptools")
    if not (ROOT / "pddecont").exists():
        pytest.skip("a wheel is tried, whose sources are not here")
    return load_setup().describe


def test_the_index_shows_no_link_into_the_repository(described):
    text = described((ROOT / "README.md").read_text())
    assert re.findall(r"\]\((?!https?://)[^)]*\)", text) == []
    assert "](" in (ROOT / "README.md").read_text()
    assert "tutorial" in text.lower()


@pytest.mark.parametrize(
    ("markdown", "shown"),
    [
        ("a [page](docs/a.md) and\n![A picture](a.png)\n\nmore", "a page and\nmore"),
        ("[two\nlines](docs/a.md#b)", "two\nlines"),
        ("[elsewhere](https://doi.org/1)", "[elsewhere](https://doi.org/1)"),
    ],
)
def test_links_lose_what_leads_nowhere(described, markdown, shown):
    assert described(markdown) == shown


def test_the_version_is_one():
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == pddecont.__version__
    assert re.findall(r'set version = "(.*?)"', (ROOT / "conda" / "meta.yaml").read_text()) == [pddecont.__version__]


def recipe():
    """Return the conda recipe with its placeholders taken for words."""
    text = re.sub(r"^{%.*%}$", "", (ROOT / "conda" / "meta.yaml").read_text(), flags=re.M)
    return yaml.safe_load(re.sub(r"{{(.*?)}}", lambda match: match[1].strip().replace('"', ""), text))


def as_conda(requirement):
    name, limit = re.fullmatch(r"([\w-]+)>=(.*)", requirement).groups()
    return f"{RENAMED.get(name, name)} >={limit}"


def test_the_recipe_has_the_requirements_of_the_metadata():
    needs = recipe()["requirements"]
    assert sorted(needs["run"]) == sorted(
        [*map(as_conda, PROJECT["dependencies"]), f"python {PROJECT['requires-python']}"]
    )
    assert sorted(needs["host"]) == sorted([*map(as_conda, BUILD), "python", "pip"])


def test_the_recipe_installs_the_commands_of_the_metadata():
    commands = [f"{name} = {target}" for name, target in PROJECT["scripts"].items()]
    assert recipe()["build"]["entry_points"] == commands


def test_the_metadata_names_the_pythons_that_wheels_are_built_for():
    text = (ROOT / "pyproject.toml").read_text()
    named = re.findall(r"Python :: (3\.\d+)$", "\n".join(PROJECT["classifiers"]), re.M)
    assert PROJECT["requires-python"] == f">={named[0]}"
    assert re.search(r'^build = "(.*)"', text, re.M)[1].split() == [f"cp{name.replace('.', '')}-*" for name in named]


def test_the_archive_takes_what_it_names_and_nothing_is_forgotten():
    lines = [line.split() for line in (ROOT / "MANIFEST.in").read_text().splitlines() if not line.startswith("#")]
    taken = {name for word, *names in lines if word in ("include", "graft") for name in names}
    # Where the archive's tests are run on a wheel, the package is not beside them.
    assert not [name for name in taken - {"pddecont"} if not (ROOT / name).exists()]
    ignored = {".venv", "build", "dist", "out", ".git"}
    there = {path.name for path in ROOT.iterdir() if not path.name.endswith(("_cache", ".egg-info", ".hypothesis"))}
    assert there - ignored <= taken | {
        ".gitignore",
        ".dockerignore",
        "MANIFEST.in",
        "pyproject.toml",
        "setup.py",
        "setup.cfg",
        "PKG-INFO",
    }


def test_the_container_file_has_known_instructions_and_copies_what_is_there():
    text = re.sub(r"^#.*\n", "", (ROOT / "Containerfile").read_text(), flags=re.M)
    words = [line.split() for line in text.splitlines() if line]
    assert {line[0] for line in words} <= {"ARG", "FROM", "RUN", "COPY", "WORKDIR", "USER", "ENTRYPOINT", "CMD"}
    assert [line[1:] for line in words if line[0] == "USER"] == [["nobody"]]
