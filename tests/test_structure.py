"""The import rules of the design, and that shipped files are in order."""

import ast
import json
from pathlib import Path

import pytest

import pddecont
from pddecont.shipped import schemas
from pddecont.shipped.find import find, folders
from tests.conftest import CONFIGS, MODELS, ROOT

PACKAGE = Path(pddecont.__file__).parent
# What each folder may import of the others.
ALLOWED = {
    "cli": {"steps", "model", "results", "plot", "report", "shipped"},
    "model": set(),
    "delay": {"orbit"},
    "orbit": {"model", "delay", "continuation", "simulate"},
    "continuation": set(),
    "stability": {"model", "delay", "orbit", "continuation"},
    "bifurcation": {"model", "orbit", "continuation", "stability"},
    "simulate": {"model", "delay"},
    "results": set(),
    "plot": {"results"},
    "report": {"results", "plot"},
    "steps": {"model", "delay", "orbit", "stability", "continuation", "bifurcation", "simulate", "results", "shipped"},
    "shipped": {"model", "steps"},
}


def modules():
    return {".".join(("pddecont", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path
            for path in PACKAGE.rglob("*.py")}  # fmt: skip


def imports(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def test_every_arrow_goes_one_way():
    for name, path in modules().items():
        parts = name.split(".")
        if len(parts) < 3:
            continue
        for target in imports(path):
            other = target.split(".")
            if other[0] == "pddecont" and len(other) > 2 and other[1] in ALLOWED and other[1] != parts[1]:
                assert other[1] in ALLOWED[parts[1]], f"{name} imports {target}"


def test_no_module_imports_itself_in_a_circle():
    known = modules()
    graph = {name: {t for t in imports(path) if t in known and t != name} for name, path in known.items()}
    done, path = set(), []

    def visit(name):
        assert name not in path, " -> ".join([*path[path.index(name):], name])
        if name not in done:
            path.append(name)
            for other in graph[name]:
                visit(other)
            path.pop()
            done.add(name)

    for name in graph:
        visit(name)


@pytest.mark.parametrize(("library", "folder"), [("h5py", "results"), ("matplotlib", "plot"), ("click", "cli"), ("rich", "cli")])
def test_libraries_stay_in_their_room(library, folder):
    for name, path in modules().items():
        if not name.startswith(f"pddecont.{folder}"):
            assert not any(t.split(".")[0] == library for t in imports(path)), name


def test_only_the_command_line_prints_or_exits():
    for name, path in modules().items():
        if not name.startswith("pddecont.cli"):
            calls = [n.func for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Call)]
            names = {f.id for f in calls if isinstance(f, ast.Name)} | {f.attr for f in calls if isinstance(f, ast.Attribute)}
            assert not names & {"print", "exit", "eval"}, name


def test_shipped_schemas_are_those_of_the_code():
    for name, schema in schemas.schemas().items():
        assert (PACKAGE / "shipped" / name).read_text() == schemas.text_of(schema), "run 'make schema'"


@pytest.mark.parametrize("path", [*MODELS, *CONFIGS], ids=lambda p: p.stem)
def test_shipped_files_fit_the_schema(path):
    from pddecont.model.document import parse_document

    data = parse_document(path.read_text(), str(path)).data
    schema = json.loads((PACKAGE / "shipped" / ("model.schema.json" if "states" in data else "run.schema.json")).read_text())
    assert set(data) <= set(schema["properties"])
    assert set(schema["required"]) <= set(data)


def test_shipped_files_are_found_by_name(in_folder):
    assert find("impact_oscillator").samefile(ROOT / "models" / "impact_oscillator.yaml")
    assert find("fig4_6").name == "fig4_6.yaml"
    assert len(folders()) == 2


def test_the_version_is_in_the_changelog():
    assert f"## {pddecont.__version__}" in (ROOT / "CHANGELOG.md").read_text()
