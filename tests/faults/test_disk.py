"""The disk is full, the folder goes away, the file is shorter, newer, locked or another's: an error that says so,
nothing lost.
"""

import os
import resource
import shutil
import subprocess
import sys

import h5py
import pytest

from pddecont.errors import ResultsError
from pddecont.results import StepWriter, read_results
from pddecont.steps.execution import execute
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.faults.runs import contents, is_beginning, plan_of, run_of, text_of
from tests.runs import change, to_yaml


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    (folder / "quick.yaml").write_text(text_of("continue"))
    execute(plan_of("continue"), folder / "quick.h5")
    return folder


def run_with_room(folder, size, *options):
    """Run the command where no file may grow beyond ``size`` bytes; return its code and what it says."""
    command = [sys.executable, "-m", "pddecont", "run", "quick.yaml", "-o", "quick.h5", "-q", *options]
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.9])
def test_a_full_disk_ends_a_run_with_a_message_and_costs_nothing(whole, tmp_path, share, tally):
    shutil.copy(whole / "quick.yaml", tmp_path)
    size = int(share * (whole / "quick.h5").stat().st_size)
    code, err = run_with_room(tmp_path, size)
    assert code == 1, err
    assert err.startswith("pddecont: quick.h5 cannot be written: File too large; what was finished is kept.")
    assert len(err.splitlines()) == 1
    reference = read_results(whole / "quick.h5")
    for name, step in (read_results(tmp_path / "quick.h5").steps if share > 0.02 else {}).items():
        assert is_beginning(step, reference.steps[name])
    assert sorted(p.name for p in tmp_path.iterdir()) == ["quick.h5"] * (share > 0.02) + ["quick.yaml"]
    assert call("run", tmp_path / "quick.yaml", "-o", tmp_path / "quick.h5", "--resume", "-q")[0] == 0
    assert same_numbers(tmp_path / "quick.h5", whole / "quick.h5")
    tally(
        "faults",
        f"disk full at {100 * share:.0f} % of the file",
        "error, finished points kept, --resume gives the same file",
    )


def same_numbers(a, b):
    """Whether two files hold the same but for the place that their model was read from."""
    a, b = ({k: v for k, v in contents(file).items() if k not in ("/", "source", "/source")} for file in (a, b))
    return a == b


def test_standard_output_on_a_full_disk_is_an_error_too(whole):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "pddecont", "info", "quick.h5"],
            cwd=whole,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
    assert done.returncode == 1
    assert done.stderr == "pddecont: standard output cannot be written: No space left on device\n"


def interfere(monkeypatch, after, deed):
    """Do a deed once so many points have been written."""
    append, count = StepWriter.append, []

    def interfering(self, *rows):
        append(self, *rows)
        count.append(1)
        if len(count) == after:
            deed()

    monkeypatch.setattr(StepWriter, "append", interfering)


@pytest.mark.parametrize(
    ("what", "deed"),
    [
        ("folder removed", lambda folder: shutil.rmtree(folder)),
        ("folder renamed", lambda folder: folder.rename(folder.with_name("away"))),
        ("file removed", lambda folder: (folder / "q.h5").unlink()),
        ("file renamed", lambda folder: (folder / "q.h5").rename(folder / "r.h5")),
        (
            "file replaced",
            lambda folder: (
                shutil.copy(folder / "q.h5", folder / "r.h5") and os.replace(folder / "r.h5", folder / "q.h5")
            ),
        ),
    ],
)
def test_a_file_that_goes_away_ends_the_run_at_the_next_point(tmp_path, monkeypatch, whole, what, deed, tally):
    folder = tmp_path / "out"
    folder.mkdir()
    interfere(monkeypatch, 3, lambda: deed(folder))
    code, _, err = call("run", whole / "quick.yaml", "-o", folder / "q.h5", "-q")
    assert code == 1
    assert "was removed, moved or replaced while this run wrote to it" in err
    moved = {
        "folder renamed": tmp_path / "away" / "q.h5",
        "file renamed": folder / "r.h5",
        "file replaced": folder / "q.h5",
    }
    if what in moved:
        assert sum(map(len, read_results(moved[what]).steps.values())) == 3
    tally("faults", f"{what} during a run", "error at the next point")


def test_a_truncated_file_is_refused_whole(whole, tmp_path, tally):
    data = (whole / "quick.h5").read_bytes()
    for k in range(40):
        path = tmp_path / "q.h5"
        path.write_bytes(data[: len(data) * k // 40])
        for command in (["info", path], ["run", whole / "quick.yaml", "-o", path, "--resume"], ["export", path]):
            code, out, err = call(*command)
            assert (code, out) == (1, "")
            assert "cannot be read as a results file" in err
        assert path.read_bytes() == data[: len(data) * k // 40]
    tally("faults", "file truncated", "refused, left as it is", 40)


def test_files_of_a_newer_version_and_of_another_model_are_left_alone(whole, tmp_path, tally):
    newer = shutil.copy(whole / "quick.h5", tmp_path / "newer.h5")
    with h5py.File(newer, "r+") as file:
        file.attrs["format_version"] += 1
    (tmp_path / "other.yaml").write_text(to_yaml(change(run_of("continue"), "parameters.c", 0.2)))
    other = shutil.copy(whole / "quick.h5", tmp_path / "other.h5")
    for path, model, words in (
        (newer, whole / "quick.yaml", "install a newer pddecont"),
        (other, tmp_path / "other.yaml", "was made from another model"),
    ):
        before = path.read_bytes()
        code, _, err = call("run", model, "-o", path, "--resume")
        assert code == 1
        assert words in err
        assert path.read_bytes() == before
    tally("faults", "file of a newer version, of another model", "refused, left as it is", 2)


@pytest.mark.parametrize("option", ["--resume", "--overwrite"])
def test_a_file_that_another_program_has_locked_is_left_alone(whole, tmp_path, option, tally):
    path = shutil.copy(whole / "quick.h5", tmp_path / "q.h5")
    holder = subprocess.Popen(
        [sys.executable, "-c", f"import h5py; f = h5py.File({str(path)!r}, 'r+'); print(1, flush=True); input()"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert holder.stdout.readline()
    before = path.read_bytes()
    code, _, err = call("run", whole / "quick.yaml", "-o", path, option)
    holder.kill()
    holder.communicate()
    assert code == 1
    assert "locked by another program" in err
    assert path.read_bytes() == before
    tally("faults", f"file locked by another program, {option}", "refused, left as it is")


@pytest.mark.parametrize("output", ["/dev/null", "/dev/full"])
def test_devices_are_not_replaced(whole, output):
    code, _, err = call("run", whole / "quick.yaml", "-o", output, "--overwrite")
    assert code == 1
    assert "not a file that can hold results" in err
    assert not os.path.isfile(output)


def test_a_folder_that_cannot_be_written_is_named(whole, tmp_path):
    code, _, err = call("run", whole / "quick.yaml", "-o", tmp_path / "none" / "q.h5")
    assert code == 1
    assert "cannot be written: No such file or directory; check the folder" in err


def test_a_link_is_not_written_through(whole, tmp_path):
    (tmp_path / "link.h5").symlink_to(tmp_path / "real.h5")
    with pytest.raises(ResultsError, match="links are not written through"):
        execute(plan_of("simulate"), tmp_path / "link.h5")
    assert (tmp_path / "link.h5").is_symlink()
    assert not (tmp_path / "real.h5").exists()
