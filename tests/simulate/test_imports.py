"""The compiler comes in with runs, and with nothing else."""

import subprocess
import sys

from tests.conftest import ROOT
from tests.runs import to_yaml

MODEL = f"{ROOT}/models/impact_oscillator.yaml"
FIRST = {
    "model": MODEL,
    "steps": [{"name": "t", "simulate": {"t_end": "60*2*pi/omega"}}, {"name": "o", "orbit": {"from": "t"}}],
}
BRANCH = {
    "from": {"file": "a.h5", "step": "o"},
    "free": ["K"],
    "range": {"K": [0.11, 0.13]},
    "max_points": 3,
    "stability": True,
    "verify": False,
}
SECOND = {"model": MODEL, "steps": [{"name": "c", "continue": BRANCH}]}
CALL = """
import sys
from pddecont.cli import main
try:
    main({arguments})
except SystemExit as exit:
    assert exit.code in (0, None), exit.code
print("llvmlite" in sys.modules, "distributed" in sys.modules)
"""


def imported(folder, *arguments):
    done = subprocess.run(
        [sys.executable, "-c", CALL.format(arguments=list(arguments))],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()[-2:]


def test_only_runs_import_the_compiler(tmp_path):
    (tmp_path / "first.yaml").write_text(to_yaml(FIRST))
    (tmp_path / "second.yaml").write_text(to_yaml(SECOND))
    assert imported(tmp_path, "run", "first.yaml", "-o", "a.h5", "-q") == ["True", "False"]
    assert imported(tmp_path, "run", "second.yaml", "-o", "b.h5", "-q") == ["True", "False"]
    for arguments in (["check", "first.yaml"], ["info", "a.h5"], ["plot", "b.h5", "-o", "b.png"], ["export", "b.h5"]):
        assert imported(tmp_path, *arguments) == ["False"] * 2
