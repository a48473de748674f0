"""What the README and the docs show is run as written."""

import re
import shlex

import pytest

from pddecont.cli import COMMANDS
from pddecont.results.reader import read_results
from tests.cli.test_cli import call
from tests.conftest import MODELS, ROOT

README = (ROOT / "README.md").read_text()


def test_the_readmes_model_runs(in_folder):
    text = re.search(r"```yaml\n(.*?)```", README, re.S).group(1)
    (in_folder / "my_model.yaml").write_text(text)
    assert call("check", "my_model.yaml")[0] == 0
    assert call("run", "my_model.yaml", "-q")[0] == 0
    step = read_results("my_model.h5").step("branch")
    assert step.labels.count("EP1") == 1
    assert max(step.points["error_estimate"]) <= 1e-8


def test_the_readmes_commands_are_commands_with_such_options():
    lines = re.findall(r"^    pddecont (.*?)(?:\s+#.*)?$", README, re.M)
    assert len(lines) >= 6
    for line in lines:
        name, *rest = shlex.split(line)
        assert name in COMMANDS
        usage = call(name, "--help")[1]
        for option in (w for w in rest if w.startswith("-")):
            assert option in usage


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


def test_documents_name_files_that_exist():
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
            assert (page.parent / target).exists(), (page, target)
        for target in re.findall(r"`((?:tests|configs|models|benchmarks|pddecont)/[\w/.]+)`", page.read_text()):
            assert (ROOT / target).exists(), (page, target)
