"""The packages' doors: what they name is there, and is imported when it is used."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

DOORS = ["pddecont.codegen", "pddecont.simulate", "pddecont.simulate.integrator", "pddecont.native.integrator"]


def folder_of(package):
    return Path(importlib.import_module(package).__file__).parent


def names_of(package):
    """Return what the stub of a package imports: (module, name)."""
    tree = ast.parse((folder_of(package) / "__init__.pyi").read_text())
    return [(node.module, alias.name) for node in tree.body for alias in node.names]


@pytest.mark.parametrize("package", DOORS)
def test_every_name_is_that_of_its_module(package):
    door = importlib.import_module(package)
    names = names_of(package)
    assert sorted(name for _, name in names) == door.__all__
    for module, name in names:
        assert getattr(door, name) is getattr(importlib.import_module(f"{package}.{module}"), name)


@pytest.mark.parametrize("package", DOORS)
def test_no_name_is_that_of_a_module(package):
    modules = {path.stem for path in folder_of(package).glob("*.py")} | {p.name for p in folder_of(package).iterdir()}
    assert not modules & {name for _, name in names_of(package)}


def test_others_come_in_by_the_door():
    """No module outside a package imports from a module inside it."""
    for path in folder_of("pddecont").rglob("*.py"):
        inside = [door for door in DOORS if path.is_relative_to(folder_of(door))]
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module and node.module not in DOORS:
                entered = [door for door in DOORS if node.module.startswith(f"{door}.")]
                assert set(entered) <= set(inside), f"{path} imports {node.module}"


@pytest.mark.parametrize(
    ("statement", "absent"),
    [
        ("import pddecont.simulate, pddecont.codegen", ["sympy", "llvmlite", "numpy"]),
        ("from pddecont.codegen import NumericModel, find_non_finite", ["llvmlite"]),
        (
            "from pddecont.simulate import Trajectory, Workers, Method, detect_period, describe_failure",
            ["llvmlite", "distributed"],
        ),
    ],
)
def test_a_name_brings_only_what_it_needs(statement, absent):
    code = f"import sys\n{statement}\nprint([m for m in {absent} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=100)
    assert done.stdout.strip() == "[]"
