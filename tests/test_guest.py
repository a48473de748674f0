"""The program is a guest: in a process of others it changes none of their settings, and it needs no home folder."""

import os
import subprocess
import sys

import pytest

from tests.conftest import ROOT

# Every setting of other libraries that a process shares, as text or numbers that can be compared.
SETTINGS = """
import decimal, gc, importlib, locale, logging, os, pkgutil, random, signal, sys, threading, warnings
import matplotlib, numpy, sympy

def settings():
    return {
        "numpy errors": numpy.geterr(), "numpy print": numpy.get_printoptions(),
        "numpy random": numpy.random.get_state()[1].tolist(), "random": random.getstate(),
        "matplotlib": dict(matplotlib.rcParams), "warnings": list(warnings.filters),
        "show warning": warnings.showwarning, "decimal": str(decimal.getcontext()),
        "locale": locale.setlocale(locale.LC_ALL),
        "logging": (logging.root.level, logging.root.handlers[:]), "excepthook": sys.excepthook,
        "thread hook": threading.excepthook, "recursion": sys.getrecursionlimit(), "path": sys.path[:],
        "garbage": (gc.isenabled(), gc.get_threshold(), gc.get_freeze_count()), "folder": os.getcwd(),
        "signals": [signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)],
        "environment": dict(os.environ),
        "sympy": str(sympy.sstr(sympy.sympify("x*y + 1/3"))),
    }
"""
COMPARED = """
now = settings()
changed = {name: (before[name], now[name]) for name in now if repr(now[name]) != repr(before[name])}
assert not changed, changed
"""
IMPORT = """
# What libraries set up by themselves when they are imported is theirs.
import matplotlib.pyplot, scipy.interpolate, scipy.linalg, scipy.optimize
import scipy.sparse.linalg, scipy.special, scipy.stats
before = settings()
import pddecont
for found in pkgutil.walk_packages(pddecont.__path__, "pddecont."):
    if not found.name.startswith(("pddecont.cli", "pddecont.__main__", "pddecont.data.")):
        importlib.import_module(found.name)
"""
RUN = """
before = settings()
results = pddecont.run("wall_oscillator", until="orbit")
results.plot("picture.png")
results.plot()
"""


def run_python(text, folder, **environment):
    kept = {name: value for name, value in os.environ.items() if name not in environment}
    kept["PYTHONPATH"] = str(ROOT) if (ROOT / "pddecont").exists() else ""
    kept.update({name: value for name, value in environment.items() if value is not None})
    return subprocess.run(
        [sys.executable, "-c", text], cwd=folder, env=kept, capture_output=True, text=True, timeout=300
    )


def test_importing_and_running_leave_the_settings_of_others_alone(tmp_path):
    done = run_python(SETTINGS + IMPORT + COMPARED + RUN + COMPARED, tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "picture.png").exists()


@pytest.mark.parametrize("change", ["numpy.seterr(all='ignore')", "warnings.simplefilter('ignore')", "gc.freeze()"])
def test_a_setting_that_is_changed_is_seen(change, tmp_path):
    done = run_python(f"{SETTINGS}\nbefore = settings()\n{change}\n{COMPARED}", tmp_path)
    assert done.returncode == 1
    assert "AssertionError" in done.stderr


@pytest.mark.parametrize("home", [None, "", "a_file", "/proc/nowhere"])
def test_no_home_folder_is_needed(home, tmp_path):
    (tmp_path / "a_file").touch()
    given = str(tmp_path / home) if home == "a_file" else home
    words = "from pddecont.cli import main; main({!r})"
    for command in (
        ["run", "wall_oscillator", "--until", "orbit", "-q", "-o", "w.h5"],
        ["plot", "w.h5", "-o", "w.png"],
    ):
        done = run_python(words.format(command), tmp_path, HOME=given, XDG_CACHE_HOME=None, XDG_CONFIG_HOME=None)
        assert done.returncode == 0, done.stderr
        assert "Traceback" not in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"a_file", "w.h5", "w.png"}
