"""Which way imports go, through which doors, and that shipped files are in order."""

import ast
import graphlib
import json
from pathlib import Path

import pytest

import pddecont
from pddecont.data import find_shipped_folders
from pddecont.model import parse_document
from pddecont.runfile.find import find_file
from pddecont.steps.json_schema import format_schema, make_schemas
from tests.conftest import CONFIGS, MODELS, ROOT

PACKAGE = Path(pddecont.__file__).parent
# What each folder may import besides what anyone may: the modules beside the folders that import nothing.
ALLOWED = {
    "collocation": {"native"},
    "continuation": {"native", "native.assembly"},
    "model": {},
    "results": {},
    "data": {},
    "intervals": {},
    "codegen": {"model"},
    "delay": {"collocation", "model", "native"},
    "native": {},
    "native.assembly": {"native"},
    "native.integrator": {"native"},
    "simulate.integrator": {"native", "native.integrator"},
    "simulate": {"native.integrator", "simulate.integrator", "codegen", "delay", "model"},
    "orbit": {"codegen", "collocation", "continuation", "delay", "model", "native", "native.assembly", "simulate"},
    "stability": {"collocation", "continuation", "delay", "native", "orbit"},
    "equilibrium": {"codegen", "collocation", "continuation", "delay", "intervals", "model"},
    "bifurcation": {"collocation", "continuation", "equilibrium", "model", "orbit", "stability"},
    "exploration": {"codegen", "collocation", "delay", "model", "results", "simulate"},
    "runfile": {"codegen", "collocation", "data", "delay", "model", "orbit"},
    "steps": {
        "bifurcation",
        "codegen",
        "collocation",
        "equilibrium",
        "model",
        "orbit",
        "results",
        "runfile",
        "simulate",
    },
    "tables": {"results", "simulate"},
    "steps.execution": {
        "bifurcation",
        "codegen",
        "collocation",
        "continuation",
        "delay",
        "equilibrium",
        "exploration",
        "model",
        "orbit",
        "results",
        "runfile",
        "simulate",
        "stability",
        "steps",
        "tables",
    },
    "plot": {"collocation", "results", "tables"},
    "plot.views": {"plot", "results", "tables"},
    "report": {"plot", "results", "tables"},
    "notebook": {"plot", "report", "results", "steps", "tables"},
    "api": {"notebook", "plot", "report", "results", "runfile", "steps", "steps.execution", "tables"},
    "cli": {"api", "data", "model", "plot", "results", "runfile", "steps", "tables"},
    "__init__": {"api"},
    "__main__": {"cli"},
}
BASE = {"errors", "memo", "output", "reasons", "version"}
# Where each library may be imported.
ROOMS = {
    "h5py": {"results"},
    "matplotlib": {"plot", "api"},
    "mpl_toolkits": {"plot"},
    "click": {"cli"},
    "rich": {"cli"},
    "jinja2": {"report", "notebook"},
    "IPython": {"notebook"},
    "pandas": {"tables", "api"},
    "xarray": {"tables", "api"},
    "plotly": {"report"},
    "llvmlite": {"codegen"},
    "distributed": {"simulate"},
}
FOLDERS = {".".join(p.parent.relative_to(PACKAGE).parts) for p in PACKAGE.rglob("__init__.py")} - {""}


def modules():
    """Return all modules: names within the package, and where they lie."""
    return {".".join(path.relative_to(PACKAGE).with_suffix("").parts): path for path in PACKAGE.rglob("*.py")}


def imports(path):
    """Yield what a module imports, whenever it does: module, and name in it (empty: the module itself)."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports by a relative name"
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)


def inner_imports(path):
    """Yield what a module imports of this package: module within it, and name in that."""
    for module, name in imports(path):
        if module.split(".")[0] == "pddecont":
            yield module.removeprefix("pddecont").removeprefix("."), name


def folder_of(module):
    """Return the folder that a module lies in, or the module itself if it lies beside the folders."""
    while module and module not in FOLDERS and "." in module:
        module = module.rpartition(".")[0]
    return module or "__init__"


def find_arrows():
    """Return which folders, or modules beside them, each imports."""
    arrows = {}
    for name, path in modules().items():
        targets = {folder_of(module) if module else folder_of(imported) for module, imported in inner_imports(path)}
        arrows.setdefault(folder_of(name), set()).update(targets - {folder_of(name)} - BASE)
    return arrows


def check_order(arrows):
    """Fail on arrows that lead round in a circle."""
    try:
        tuple(graphlib.TopologicalSorter(arrows).static_order())
    except graphlib.CycleError as exc:
        pytest.fail(f"a cycle: {' -> '.join(exc.args[1])}")


def list_past_doors(name, path):
    """Return what a module imports from inside another folder instead of through that folder's door."""
    own = name.split(".")[0]
    return [
        f"{module}.{imported}"
        for module, imported in inner_imports(path)
        if module not in FOLDERS and folder_of(module) in FOLDERS and module.split(".")[0] != own
    ]


def test_what_is_allowed_has_an_order():
    check_order(ALLOWED)


@pytest.mark.parametrize("arrows", [{"a": {"b"}, "b": {"c"}, "c": {"a"}}, {"a": {"b"}, "b": {"a"}}])
def test_a_cycle_cannot_be_allowed(arrows):
    with pytest.raises(pytest.fail.Exception, match="a cycle"):
        check_order(arrows)


def test_folders_import_what_they_may():
    for folder, targets in find_arrows().items():
        assert targets <= set(ALLOWED.get(folder, {})), f"{folder} imports {targets - set(ALLOWED.get(folder, {}))}"


def test_nothing_is_allowed_that_is_not_needed():
    arrows = find_arrows()
    assert {name: set(targets) for name, targets in ALLOWED.items() if targets} == {
        name: targets for name, targets in arrows.items() if targets
    }


def test_no_module_imports_itself_in_a_circle():
    known = modules()
    graph = {}
    for name, path in known.items():
        targets = {t for module, imported in inner_imports(path) for t in (module, f"{module}.{imported}")}
        graph[name] = targets & set(known) - {name}
    check_order(graph)


def test_folders_are_entered_by_their_doors():
    past = {name: list_past_doors(name, path) for name, path in modules().items()}
    assert {name: found for name, found in past.items() if found} == {}


def test_an_import_past_a_door_is_seen(tmp_path):
    path = tmp_path / "m.py"
    path.write_text("from pddecont.orbit.problem import OrbitProblem\nfrom pddecont.orbit import Orbit\n")
    assert list_past_doors("plot.m", path) == ["orbit.problem.OrbitProblem"]
    assert list_past_doors("orbit.m", path) == []


@pytest.mark.parametrize("folder", sorted(FOLDERS))
def test_a_door_names_what_is_there_and_no_module_hides_it(folder):
    door = PACKAGE.joinpath(*folder.split("."), "__init__.pyi")
    if not door.exists():
        assert not list(door.parent.glob("[!_]*.py")) or folder in {
            "cli",
            "native",
            "native.assembly",
            "plot.views",
            "data.starters",
        }
        return
    package = __import__(f"pddecont.{folder}", fromlist=["_"])
    for node in ast.parse(door.read_text()).body:
        for alias in node.names:
            assert alias.name == alias.asname
            assert not (door.parent / f"{alias.name}.py").exists(), f"module {alias.name} hides a name of the door"
            assert getattr(package, alias.name) is not None


@pytest.mark.parametrize(("library", "folders"), ROOMS.items())
def test_libraries_stay_in_their_room(library, folders):
    users = {name for name, path in modules().items() for m, _ in imports(path) if m.split(".")[0] == library}
    assert {name.split(".")[0] for name in users} == folders, users


def test_only_the_command_line_prints_or_exits():
    for name, path in modules().items():
        if not name.startswith("cli."):
            calls = [n.func for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Call)]
            names = {f.id for f in calls if isinstance(f, ast.Name)} | {
                f.attr for f in calls if isinstance(f, ast.Attribute)
            }
            assert not names & {"print", "exit", "eval"}, name


def test_shipped_schemas_are_those_of_the_code():
    for name, schema in make_schemas().items():
        assert (PACKAGE / "data" / name).read_text() == format_schema(schema), "run 'make schema'"


@pytest.mark.parametrize("path", [*MODELS, *CONFIGS], ids=lambda p: p.stem)
def test_shipped_files_fit_the_schema(path):
    data = parse_document(path.read_text(), str(path)).data
    schema = json.loads(
        (PACKAGE / "data" / ("model.schema.json" if "states" in data else "run.schema.json")).read_text()
    )
    assert set(data) <= set(schema["properties"])
    assert set(schema["required"]) <= set(data)


def test_shipped_files_are_found_by_name(in_folder):
    assert find_file("impact_oscillator").samefile(ROOT / "models" / "impact_oscillator.yaml")
    assert find_file("fig4_6").name == "fig4_6.yaml"
    assert len(find_shipped_folders()) == 2


def test_the_version_is_in_the_changelog():
    assert f"## {pddecont.__version__}" in (ROOT / "CHANGELOG.md").read_text()
