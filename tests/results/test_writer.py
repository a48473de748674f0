"""The results file: round trips, growth, and a process killed while it writes."""

import os
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.errors import ResultsError
from pddecont.reasons import make_reason
from pddecont.results import Column, StepFormat, StepWriter, create_results, drop_steps, read_results

FORMAT = StepFormat(
    "continue",
    {"kind": Column("S2"), "arclength": Column("f8"), "v": Column("f8", (2,))},
    {"rows": Column("f8", (3,)), "flat": Column("i8")},
    has_branch=True,
)
META = {"directions": 1}


def new(path, **options):
    create_results(path, "model text", "run text", "run.yaml", "{}", **options)


def row(i):
    return (
        {"kind": b"GR" if i == 3 else b"", "arclength": float(-i), "v": [i, i + 0.5]},
        {"rows": np.full((i % 4, 3), i, dtype=float), "flat": np.arange(i)},
    )


@settings(max_examples=20, deadline=None)
@given(n=st.integers(0, 90), capacity=st.integers(1, 70))
def test_what_is_written_is_read_back(tmp_path_factory, n, capacity):
    path = tmp_path_factory.mktemp("r") / "a.h5"
    new(path)
    with StepWriter(path, "branch", FORMAT, META, capacity=capacity) as writer:
        for i in range(n):
            writer.append(*row(i))
        writer.terminate(make_reason("max_points", direction=1))
    step = read_results(path).step("branch")
    assert len(step) == n
    assert step.done
    assert step.endings == (make_reason("max_points", direction=1),)
    for i in range(n):
        points, orbits = row(i)
        assert np.array_equal(step.points["v"][i], points["v"])
        assert np.array_equal(step.orbit(i)["rows"], orbits["rows"])
        assert np.array_equal(step.orbit(i)["flat"], orbits["flat"])
    with h5py.File(path) as file:
        assert file["steps/branch/points/v"].shape == (n, 2)


def test_unfinished_rows_are_there_before_the_step_is_closed(tmp_path):
    path = tmp_path / "a.h5"
    new(path)
    writer = StepWriter(path, "branch", FORMAT, META)
    for i in range(5):
        writer.append(*row(i))
        assert len(read_results(path).step("branch")) == i + 1
    assert not read_results(path).step("branch").done
    # Going on from the first three rows.
    writer = StepWriter(path, "branch", FORMAT, META, recorded=read_results(path).step("branch"), kept=3)
    assert len(read_results(path).step("branch")) == 3
    writer.append(*row(3))
    writer.close()
    step = read_results(path).step("branch")
    assert [step.points["v"][i, 0] for i in range(4)] == [0, 1, 2, 3]
    assert step.labels == ("", "", "", "GR1")


def test_labels_are_numbered_along_the_branch(tmp_path):
    path = tmp_path / "a.h5"
    new(path)
    with StepWriter(path, "branch", FORMAT, META) as writer:
        for arclength, kind in ((0, b""), (-1, b"GR"), (-2, b"EP"), (3, b"GR")):
            writer.append(
                {"kind": kind, "arclength": arclength, "v": [0, 0]}, {"rows": np.zeros((0, 3)), "flat": np.zeros(0)}
            )
    step = read_results(path).step("branch")
    assert step.labels == ("", "GR1", "EP1", "GR2")
    assert step.row("GR2") == 3
    with pytest.raises(ResultsError, match=r"no point 'GR3'; did you mean"):
        step.row("GR3")


def test_an_existing_file_is_never_overwritten_unasked(tmp_path):
    path = tmp_path / "a.h5"
    path.write_text("precious")
    with pytest.raises(ResultsError, match="exists already"):
        new(path)
    with pytest.raises(ResultsError, match="is not a results file"):
        new(path, overwrite=True)
    assert path.read_text() == "precious"
    path.unlink()
    create_results(path, "an older model", "run text", "run.yaml", "{}")
    with pytest.raises(ResultsError, match="exists already"):
        new(path)
    assert read_results(path).model_text == "an older model"
    new(path, overwrite=True)
    assert read_results(path).model_text == "model text"


def test_steps_can_be_dropped(tmp_path):
    path = tmp_path / "a.h5"
    new(path)
    for name in ("one", "two"):
        with StepWriter(path, name, StepFormat("orbit", FORMAT.points), META) as writer:
            writer.append(row(1)[0])
    drop_steps(path, ["one"])
    assert list(read_results(path).steps) == ["two"]


@pytest.mark.parametrize("content", [b"", b"not hdf5", b"\x89HDF\r\n\x1a\n" + bytes(200)])
def test_files_that_are_no_results_are_refused(tmp_path, content):
    path = tmp_path / "a.h5"
    path.write_bytes(content)
    with pytest.raises(ResultsError):
        read_results(path)


def test_a_newer_format_is_refused(tmp_path):
    path = tmp_path / "a.h5"
    new(path)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 99
    with pytest.raises(ResultsError, match="install a newer pddecont"):
        read_results(path)


WRITE = """
import sys; sys.path.insert(0, {root!r})
from pathlib import Path
from tests.results.test_writer import FORMAT, META, StepWriter, row
writer = StepWriter(Path({path!r}), "branch", FORMAT, META, capacity=2)
for i in range(100000):
    writer.append(*row(i % 200))
    print(i + 1, flush=True)
"""


def test_a_killed_process_leaves_every_finished_point(tmp_path):
    from tests.conftest import ROOT

    rng = np.random.default_rng(0)
    for k in range(12):
        path = tmp_path / f"{k}.h5"
        new(path)
        process = subprocess.Popen(
            [sys.executable, "-c", WRITE.format(root=str(ROOT), path=str(path))], stdout=subprocess.PIPE
        )
        assert process.stdout is not None
        assert process.stdout.readline()
        time.sleep(rng.uniform(0.0, 0.15))
        os.kill(process.pid, signal.SIGKILL)
        reported = [int(line) for line in process.stdout.read().split(b"\n")[:-1] if line] or [1]
        process.stdout.close()
        process.wait()
        step = read_results(path).step("branch")
        assert len(step) >= reported[-1]
        for i in range(len(step)):
            points, orbits = row(i % 200)
            assert np.array_equal(step.points["v"][i], points["v"])
            assert np.array_equal(step.orbit(i)["rows"], orbits["rows"])


def test_a_file_does_not_say_when_its_arrays_were_made(tmp_path):
    """A run gives the same bytes at any time."""
    path = tmp_path / "a.h5"
    new(path)
    with StepWriter(path, "branch", FORMAT, META) as writer:
        for i in range(5):
            writer.append(*row(i))
        writer.terminate(make_reason("max_points", direction=1))
    times = []
    with h5py.File(path) as file:
        file.visititems(lambda name, item: times.append(h5py.h5o.get_info(item.id).ctime))
    assert len(times) > 12
    assert not any(times)
