"""Results files from strangers: damaged, or made to be read as something else."""

import json
import math
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import h5py
import numpy as np
import pytest

from pddecont.reasons import make_reason
from pddecont.steps.execution import execute
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.faults.runs import plan_of, text_of
from tests.hostile.bytes_of_files import look

NUMBER = 300


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    for kind in ("continue", "sweep", "basin"):
        execute(plan_of(kind), folder / f"{kind}.h5")
        (folder / f"{kind}.yaml").write_text(text_of(kind))
    with h5py.File(folder / "secret.h5", "w") as file:
        file["data"] = np.arange(1000.0)
    (folder / "secret.bin").write_bytes(b"hunter2 " * 4000)
    return folder


def count(tally, what, tried, refused):
    tally("inputs", what, "refused", refused)
    if refused < tried:
        tally("inputs", what, "read", tried - refused)


def names_of(path):
    found = []
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return [name for name in found if "/last/" in name or "/" not in name]


def chunked(parent, leaf, old, **options):
    parent.create_dataset(
        leaf, shape=(10**12, *old.shape[1:]), maxshape=(None, *old.shape[1:]), dtype=old.dtype, chunks=True, **options
    )


def huge(parent, leaf, old):
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_layout(h5py.h5d.CONTIGUOUS)
    plist.set_alloc_time(h5py.h5d.ALLOC_TIME_LATE)
    space = h5py.h5s.create_simple((10**11, *old.shape[1:]))
    h5py.h5d.create(parent.id, leaf.encode(), h5py.h5t.py_create(old.dtype, logical=True), space, dcpl=plist)


def virtual(parent, leaf, old):
    layout = h5py.VirtualLayout(shape=(1000,), dtype="f8")
    layout[:] = h5py.VirtualSource("secret.h5", "data", shape=(1000,))
    parent.create_virtual_dataset(leaf, layout)


def references(parent, leaf, old):
    parent.create_dataset(leaf, data=[parent.ref], dtype=h5py.ref_dtype)


def put(values):
    return lambda parent, leaf, old: parent.create_dataset(leaf, data=values(old))


def link(target):
    def replace(parent, leaf, old):
        parent[leaf] = target

    return replace


CHANGES = {
    "missing": lambda parent, leaf, old: None,
    "an external link": link(h5py.ExternalLink("secret.h5", "/data")),
    "a soft link": link(h5py.SoftLink("/steps")),
    "a link that leads nowhere": link(h5py.SoftLink("/nowhere")),
    "a group": lambda parent, leaf, old: parent.create_group(leaf),
    "virtual": virtual,
    "references": references,
    "10^11 rows": huge,
    "10^12 rows that are not there": chunked,
    "with a filter": lambda parent, leaf, old: chunked(parent, leaf, old, compression="gzip"),
    "data in another file": lambda parent, leaf, old: parent.create_dataset(
        leaf, (1000,), "f8", external=[("secret.bin", 0, 8000)]
    ),
    "text of any length": put(lambda old: ["x"] * 3),
    "complex": put(lambda old: np.zeros(max(old.shape[:1], default=1), complex)),
    "empty": put(lambda old: np.zeros((0, *old.shape[1:]), old.dtype)),
    "one number": put(lambda old: 3.0),
    "one axis more": put(lambda old: np.zeros((*(old.shape or (1,)), 2), old.dtype)),
    "text": put(lambda old: np.full(max(old.size, 1), b"\xff\x1b[2J")),
    "negative": put(lambda old: np.full(old.shape, -7, old.dtype if old.dtype.kind in "fi" else "i8")),
    "very large": put(lambda old: np.full(old.shape, 2**62, "i8")),
    "not finite": put(lambda old: np.full(old.shape, np.nan)),
    "falling": put(lambda old: np.arange(old.size)[::-1].reshape(old.shape).astype("i8")),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("kind", ["continue", "sweep", "basin"])
def test_arrays_that_are_something_else(files, tmp_path, monkeypatch, kind, change, tally):
    monkeypatch.chdir(files)
    refused, names = 0, names_of(files / f"{kind}.h5")
    not_refused = []
    for name in names:
        path = Path(shutil.copy(files / f"{kind}.h5", tmp_path / "a.h5"))
        with h5py.File(path, "r+") as file:
            parent, leaf, old = file[name].parent, name.rpartition("/")[2], file[name]
            old_shape, old_kind = old.shape, old.dtype.kind
            del parent[leaf]
            CHANGES[change](parent, leaf, old)
        for name_of_secret in ("secret.h5", "secret.bin"):
            shutil.copy(files / name_of_secret, tmp_path)
        if not look(path):
            refused += 1
        elif "special_points" not in name and math.prod(old_shape[1:]) and old_kind != "S":
            not_refused.append(name)
    assert refused > 0
    if change not in ("missing", "negative", "not finite", "falling", "empty", "very large"):
        # Nothing that is not a plain array is read, wherever it stands; numbers may be any numbers where nothing is
        # counted by them.
        assert not_refused == []
    count(tally, f"results files, an array {change}", len(names), refused)


@pytest.mark.parametrize(
    "meta",
    [
        "null",
        "[]",
        "1",
        "{",
        '{"parameters": 3}',
        '{"parameters": ["a", "a"]}',
        '{"parameters": ["$\\\\frac{"]}',
        '{"states": [["x"]]}',
        '{"directions": "many"}',
        '{"free": ["nobody"]}',
        "[" * 100_000,
        '{"x": ["a"]}',
        '{"settings": {}}',
        '{"ends": null}',
        '{"ends": 3}',
        '{"ends": [[1, 2, 3]]}',
        '{"section": null}',
        '{"section": {"phase": "x"}}',
        '{"curve": 3}',
        '{"free": null}',
        '{"units": null}',
        '{"units": {"x": 3}}',
        '{"settings": "x"}',
        '{"settings": "[]"}',
        '{"settings": "{\\"left_out\\": 3}"}',
        '{"settings": "{\\"left_out\\": {\\"effects\\": [3]}}"}',
        '{"settings": "{\\"left_out\\": {\\"x\\": 1}}"}',
    ],
)
def test_settings_that_are_something_else(files, tmp_path, meta):
    path = Path(shutil.copy(files / "continue.h5", tmp_path / "a.h5"))
    with h5py.File(path, "r+") as file:
        del file["steps/last/meta"]
        file.create_dataset("steps/last/meta", data=meta.encode(), dtype=h5py.string_dtype("utf-8", len(meta)))
    for command in (
        ["info", path],
        ["export", path],
        ["plot", path, "-o", tmp_path / "p.png"],
        ["report", path, "-o", tmp_path / "p.html"],
        ["run", files / "continue.yaml", "-o", path, "--resume"],
    ):
        code, out, err = call(*command)
        assert (code, out) == (1, ""), command
        assert "a.h5" in err


@pytest.mark.parametrize("kind", ["continue", "sweep", "basin"])
def test_columns_of_any_numbers_are_drawn_or_refused(files, tmp_path, kind, tally):
    tried = 0
    for value in (np.nan, np.inf, 1e308):
        for name in [n for n in names_of(files / f"{kind}.h5") if "/last/" in n]:
            path = Path(shutil.copy(files / f"{kind}.h5", tmp_path / "a.h5"))
            with h5py.File(path, "r+") as file:
                if file[name].dtype.kind != "f" or name.rpartition("/")[2] not in (
                    "parameters",
                    "monitors",
                    "states",
                    "returns",
                    "settling",
                    "arclength",
                    "period",
                ):
                    continue
                file[name][:] = value
            tried += 1
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # matplotlib says of axes that they have no extent
                code, _, err = call("plot", path, "-o", tmp_path / "p.png")
            assert code in (0, 1), (name, value)
            assert "Traceback" not in err
    tally("inputs", "results files, a column of NaN, infinity or 1e308", "drawn or refused", tried)


@pytest.mark.parametrize(
    "row", [[np.nan], [1e300], [-1.0], [0.0], [5, 1, 3, 1e9, *[0.0] * 36], [1e9, 1, 1, 1, *[0.0] * 36], [7.0]]
)
@pytest.mark.parametrize("array", ["mesh", "unknowns", "states", "tangent"])
def test_recorded_orbits_that_are_none(files, tmp_path, array, row):
    path = Path(shutil.copy(files / "continue.h5", tmp_path / "a.h5"))
    with h5py.File(path, "r+") as file:
        place = file[f"steps/orbit/orbits/{array}"]
        place[:] = np.resize(np.array(row), place.shape)
        del file["steps/last"]
    code, _, err = call("run", files / "continue.yaml", "-o", path, "--resume", "-q")
    # What is recorded is a guess for Newton's method: another guess may lead to the orbit too.
    assert code in (0, 1, 3), err
    assert "Traceback" not in err
    if array == "mesh":
        assert code == 1
        assert "is not an orbit of this model" in err


def test_recorded_states_of_integrations_are_checked_before_machine_code_sees_them(files, tally):
    """Forks of another process try them: machine code does not ask before it reads."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "tests.hostile.integrations", str(files / "sweep.h5"), "150"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-1000:]
    found = json.loads(done.stdout)
    assert found["ended"] == []
    assert found["refused"] > 20
    count(tally, "recorded states of integrations, numbers changed", 150, found["refused"])


@pytest.mark.parametrize("kind", ["continue", "sweep", "basin"])
def test_bytes_that_are_changed_do_not_end_the_process(files, kind, tally):
    command = [
        sys.executable,
        "-W",
        "error",
        "-m",
        "tests.hostile.bytes_of_files",
        str(files / f"{kind}.h5"),
        str(NUMBER),
        "0",
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-1000:]
    found = json.loads(done.stdout)
    assert found["ended"] == []
    assert found["read"] + found["refused"] == NUMBER
    assert found["refused"] > NUMBER // 4
    count(tally, "results files, bytes changed", NUMBER, found["refused"])


ENDINGS = [
    b"reached the end",
    b"[]",
    b'{"values": 3}',
    b'{"code": 3}',
    b'{"code": "range", "value": [1]}',
    b'{"code": "range"}',
    b'{"code": "range", "direction": "up"}',
    b'{"code": "range", "direction": NaN}',
    b'{"code": "range", "direction": 1, "detail": "range", "parameter": "wall", "value": "much"}',
    b'{"code": "limit", "direction": 1, "detail": "no exponent", "cause": "no exponent"}',
    b'{"code": "limit", "direction": 1, "detail": "vanishing"}',
    b'{"code": "limit", "direction": 1, "unexplained": "many"}',
    b'{"code": "limit", "direction": 1, "unexplained": Infinity}',
    b"[" * 4000,
    b'{"code": "' + b"x" * 4000,
    b"\xff\xfe",
]


@pytest.mark.parametrize("ending", ENDINGS, ids=lambda ending: ending[:80])
def test_endings_that_lack_what_belongs_to_them(files, tmp_path, ending):
    path = Path(shutil.copy(files / "continue.h5", tmp_path / "a.h5"))
    with h5py.File(path, "r+") as file:
        file["steps/last/termination"][1] = ending
    for command in (["info", path], ["report", path, "-o", tmp_path / "p.html"]):
        code, out, err = call(*command)
        assert (code, out) == (1, ""), command
        assert "the file is damaged" in err
    assert call("run", files / "continue.yaml", "-o", path, "--resume", "-q")[0] in (0, 1)


@pytest.mark.parametrize("kind", ["sweep", "basin"])
def test_endings_and_reasons_of_motions_that_lack_what_belongs_to_them(files, tmp_path, kind):
    path = Path(shutil.copy(files / f"{kind}.h5", tmp_path / "a.h5"))
    reason = b'{"code": "no exponent", "cause": "no exponent"}'
    with h5py.File(path, "r+") as file:
        group = file["steps/last/orbits"]
        for name, values in (("reason", np.frombuffer(reason, np.uint8)), ("reason_end", group["reason_end"][:])):
            del group[name]
            group[name] = values if name == "reason" else np.full_like(values, len(reason))
    for command in (["export", path], ["report", path, "-o", tmp_path / "p.html"]):
        code, out, err = call(*command)
        assert (code, out) == (1, ""), command
        assert "what belongs to the reason 'no exponent' is not there; the file is damaged" in err


def test_names_do_not_reach_the_terminal_as_commands(files, tmp_path):
    path = Path(shutil.copy(files / "continue.h5", tmp_path / "a.h5"))
    hidden = make_reason("text", text="\x1b[2J\x07up: \xff").to_json().encode()
    for ending, expected in ((hidden, 0), (b"\x1b[2J\x07", 1), (b'{"code": "\\u001b[2J", "direction": "up"}', 1)):
        with h5py.File(path, "r+") as file:
            file["steps/last/termination"][0] = ending
        code, out, err = call("info", path)
        assert code == expected
        assert "\x1b" not in out + err
        assert "\\x1b[2J" in out or expected
