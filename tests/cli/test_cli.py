"""The commands as a user types them: exit codes, output, what is left alone."""

import csv
import io
import json
import subprocess
import sys

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from pddecont.cli import COMMANDS, group, main
from pddecont.cli.export import to_csv
from pddecont.results import read_results
from pddecont.tables import describe_endings

# As a text, as the places of errors are shown.
QUICK_TEXT = """\
name: quick
states: [x, v]
parameters: {omega: 2, c: 0.1, wall: 0.2, r: 0.8}
forcing: {period: 2*pi/omega}
modes: {free: {x': v, v': cos(omega*t) - c*v - x}}
events: {hit: x - wall}
resets: {bounce: {v: -r*v}}
segments: {flight: {mode: free, event: hit, direction: rising, reset: bounce, to: free}}
effects: {damping: {set: {c: 0}}, wall: {drop: [hit]}}
run:
  mesh: {degree: 5, intervals: 14}
  monitors: {top: max(x), speed: "at(flight, v)"}
  steps:
    - {name: transient, simulate: {t_end: 60*pi}}
    - {name: orbit, orbit: {from: transient, signature: [flight]}}
    - {name: branch, continue: {from: orbit, free: [wall], range: {wall: [0.15, 0.3]}, step: {max: 0.05}}}
"""
QUICK = yaml.safe_load(QUICK_TEXT)


def call(*args):
    """Return (exit code, standard output, standard error) of a command."""
    import contextlib

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as info:
        main([str(a) for a in args])
    code = info.value.code
    return int(code or 0), out.getvalue(), err.getvalue()


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("done")
    (folder / "quick.yaml").write_text(QUICK_TEXT)
    code, out, err = call("run", folder / "quick.yaml", "-o", folder / "quick.h5", "--json")
    assert code == 0, err
    return folder, json.loads(out)


def test_every_command_is_there_and_has_help():
    runner = CliRunner()
    listing = runner.invoke(group, ["--help"]).output
    for name in COMMANDS:
        assert name in listing
        assert "Usage" in runner.invoke(group, [name, "--help"]).output


def test_help_and_check_load_no_heavy_library():
    code = (
        "import sys, pddecont.cli as c\ntry: c.main({args})\nexcept SystemExit: pass\n"
        "print(sorted(m for m in sys.modules if m in {heavy}))"
    )
    heavy = {"matplotlib", "h5py", "scipy.integrate", "sympy", "numpy"}
    text = code.format(args=["--help"], heavy=heavy)
    assert (
        subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
        .stdout.strip()
        .endswith("[]")
    )
    text = code.format(args=["check", "impact_oscillator"], heavy={"matplotlib", "h5py"})
    assert (
        subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
        .stdout.strip()
        .endswith("[]")
    )


def test_run_json_says_what_was_computed(done):
    folder, data = done
    assert [s["name"] for s in data["steps"]] == ["transient", "orbit", "branch"]
    assert data["steps"][2]["special"] == ["EP1", "EP2"]
    assert data["output"] == str(folder / "quick.h5")


def test_an_output_that_exists_is_not_touched(done):
    folder, _ = done
    before = (folder / "quick.h5").read_bytes()
    code, _, err = call("run", folder / "quick.yaml", "-o", folder / "quick.h5")
    assert code == 1
    assert "exists already; give --resume" in err
    assert (folder / "quick.h5").read_bytes() == before


def test_a_single_step_does_not_touch_an_existing_output_either(done):
    folder, _ = done
    before = (folder / "quick.h5").read_bytes()
    assert call("run", folder / "quick.yaml", "-o", folder / "quick.h5", "--only", "orbit")[0] == 1
    assert (folder / "quick.h5").read_bytes() == before


def test_resume_of_a_finished_run_changes_nothing(done):
    folder, _ = done
    before = read_results(folder / "quick.h5").step("branch").points["parameters"]
    assert call("run", folder / "quick.yaml", "-o", folder / "quick.h5", "--resume", "-q")[0] == 0
    assert np.array_equal(read_results(folder / "quick.h5").step("branch").points["parameters"], before)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "range: {wall: [0.15",
            "range: {wall: [0.16",
            "by another run of this model: what has changed is the model file's 'run' block",
        ),
        ("r: 0.8", "r: 0.9", "was made from another model than the one given now"),
    ],
)
def test_resume_refuses_another_run_or_model(done, tmp_path, old, new, words):
    folder, _ = done
    assert old in QUICK_TEXT
    before = (folder / "quick.h5").read_bytes()
    (tmp_path / "quick.yaml").write_text(QUICK_TEXT.replace(old, new))
    code, _, err = call("run", tmp_path / "quick.yaml", "-o", folder / "quick.h5", "--resume")
    assert code == 1
    assert words in err
    assert (folder / "quick.h5").read_bytes() == before


@pytest.mark.parametrize("keep", [1, 2, 5, 9, 14])
def test_resume_gives_the_same_numbers_as_an_uninterrupted_run(done, tmp_path, keep, monkeypatch):
    from pddecont.steps.execution import continuation

    folder, _ = done
    (tmp_path / "quick.yaml").write_text(QUICK_TEXT)
    count = {"n": 0}
    record = continuation._Branch.record

    def stop(self, point):
        record(self, point)
        count["n"] += 1
        if count["n"] == keep:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(continuation._Branch, "record", stop)
        assert call("run", tmp_path / "quick.yaml", "-o", tmp_path / "quick.h5", "-q")[0] == 130
    assert len(read_results(tmp_path / "quick.h5").step("branch")) == keep
    assert call("run", tmp_path / "quick.yaml", "-o", tmp_path / "quick.h5", "--resume", "-q")[0] == 0
    whole, resumed = (read_results(f / "quick.h5").step("branch") for f in (folder, tmp_path))
    for name in whole.points:
        assert np.array_equal(
            whole.points[name], resumed.points[name], equal_nan=whole.points[name].dtype.kind == "f"
        ), name
    assert np.array_equal(whole.orbits["states"], resumed.orbits["states"])
    assert describe_endings(whole) == describe_endings(resumed)


def test_export_tables(done):
    folder, _ = done
    code, out, _ = call("export", folder / "quick.h5", "--step", "branch")
    rows = list(csv.DictReader(io.StringIO(out)))
    assert code == 0
    assert {"label", "kind", "wall", "period", "stable", "admissible", "top", "speed", "error_estimate"} <= set(rows[0])
    walls = [float(r["wall"]) for r in rows]
    assert walls == sorted(walls)
    assert rows[0]["label"] == "EP1"
    assert float(rows[0]["top"]) == pytest.approx(0.15, abs=1e-9)
    special = json.loads(call("export", folder / "quick.h5", "--table", "special", "--format", "json")[1])
    assert [r["label"] for r in special] == ["EP1", "EP2"]
    assert special[0]["stable"] is None
    orbit = list(
        csv.DictReader(io.StringIO(call("export", folder / "quick.h5", "--table", "orbit", "--label", "EP1")[1]))
    )
    assert float(orbit[-1]["x"]) == pytest.approx(0.15, abs=1e-12)
    events = list(csv.DictReader(io.StringIO(call("export", folder / "quick.h5", "--table", "events")[1])))
    assert float(events[-1]["v_after"]) == pytest.approx(-0.8 * float(events[-1]["v"]), rel=1e-12)
    assert {"t", "segment", "x", "v", "x_after", "v_after"} == set(events[0])
    trajectory = list(csv.DictReader(io.StringIO(call("export", folder / "quick.h5", "--table", "trajectory")[1])))
    assert {"t", "mode", "x", "v"} == set(trajectory[0])
    assert call("export", folder / "quick.h5", "--table", "orbit", "--step", "transient")[0] == 1


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_plot_writes_each_format(done, tmp_path, suffix):
    folder, _ = done
    assert call("plot", folder / "quick.h5", "-o", tmp_path / f"p.{suffix}")[0] == 0
    magic = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
    assert (tmp_path / f"p.{suffix}").read_bytes().startswith(magic)


@pytest.mark.parametrize(
    "options",
    [
        ["--view", "orbit"],
        ["--view", "orbit", "--label", "EP1", "--index", "3"],
        ["--view", "profile"],
        ["--step", "transient"],
        ["--step", "orbit"],
        ["-x", "wall", "-y", "period"],
        ["--view", "orbit", "-x", "v", "-y", "x"],
    ],
)
def test_plot_views(done, tmp_path, options):
    folder, _ = done
    code, _, err = call("plot", folder / "quick.h5", "-o", tmp_path / "p.png", *options)
    assert code == 0, err
    assert (tmp_path / "p.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "p.bmp"], "pictures are"),
        (["-y", "tp"], "no column 'tp'; did you mean 'top'"),
        (["--step", "branhc"], "did you mean 'branch'"),
        (["--view", "orbit", "--label", "GR1"], "no point 'GR1'"),
        (["--view", "diagram", "--step", "orbit"], "not as diagram"),
    ],
)
def test_plot_errors(done, in_folder, options, words):
    folder, _ = done
    code, _, err = call("plot", folder / "quick.h5", *options)
    assert code == 1
    assert words in err


def test_info(done):
    folder, _ = done
    data = json.loads(call("info", folder / "quick.h5", "--json")[1])
    assert set(data["steps"][2]) >= {"name", "kind", "n_points", "special", "termination"}
    assert "branch" in call("info", folder / "quick.h5")[1]
    text = call("info", "impact_oscillator", "--without", "feedback")[1]
    assert "tau_d: nothing left is delayed by it without effect 'feedback'" in text
    assert call("info", folder / "none.h5")[0] == 1


def test_a_note_that_is_a_formula_is_none_in_a_table():
    rows = [{"label": "EP1", "note": note, "K": -0.5} for note in ("=cmd|' /C calc'!A0", "@x", "+1", "-1", "plain")]
    lines = list(csv.DictReader(io.StringIO(to_csv(rows))))
    assert [line["note"] for line in lines] == ["'=cmd|' /C calc'!A0", "'@x", "'+1", "'-1", "plain"]
    assert {line["K"] for line in lines} == {"-0.5"}


def test_help_shows_no_marks_of_its_own():
    for name in COMMANDS:
        assert "\\b" not in call(name, "--help")[1]


@pytest.mark.parametrize(
    ("args", "code"),
    [
        (["run"], 2),
        (["run", "nothing.yaml"], 1),
        (["frobnicate"], 2),
        (["run", "m.yaml", "--set", "wall"], 2),
        (["run", "m.yaml", "--set", "wal=1"], 1),
        (["run", "m.yaml", "--set", "wall=__import__('os')"], 1),
        (["export", "m.h5", "--label", "GR1", "--index", "2"], 2),
        (["run", "m.yaml", "--without", "air"], 1),
        (["run", "m.yaml", "--only", "brnch"], 1),
        (["info", "none.h5"], 1),
        (["--help"], 0),
    ],
)
def test_exit_codes(in_folder, args, code):
    (in_folder / "m.yaml").write_text(QUICK_TEXT)
    assert call(*args)[0] == code
    assert not list(in_folder.glob("*.h5"))


def test_a_run_that_does_not_converge_keeps_what_came_before(in_folder):
    # Without damping the free oscillation never dies out: no period is found.
    (in_folder / "m.yaml").write_text(QUICK_TEXT)
    code, _, err = call("run", "m.yaml", "--without", "damping", "--without", "wall", "--set", "omega=2.2")
    assert code in (1, 3)
    (in_folder / "n.yaml").write_text(
        QUICK_TEXT.replace("signature: [flight]", "from: transient").replace("{from: transient, from", "{from")
    )
    code, _, err = call("run", "n.yaml", "--set", "c=0", "--set", "r=1", "--set", "omega=2.2")
    assert code == 3, err
    assert "has not settled" in err
    assert "raise 't_end'" in err
    assert list(read_results("n.h5").steps) == ["transient"]


def test_standard_input_and_overrides(in_folder, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO(QUICK_TEXT))
    code, out, err = call("run", "-", "--set", "wall=0.1 + 0.15", "--until", "orbit", "--json", "-o", "a.h5")
    assert code == 0, err
    step = read_results("a.h5").step("orbit")
    assert step.points["parameters"][0][step.meta["parameters"].index("wall")] == 0.25
    assert [s["name"] for s in json.loads(out)["steps"]] == ["transient", "orbit"]


def test_code_in_a_model_never_runs(in_folder):
    target = in_folder / "touched"
    text = QUICK_TEXT.replace("{hit: x - wall}", f"{{hit: __import__('pathlib').Path('{target}').touch()}}")
    (in_folder / "m.yaml").write_text(text)
    code, _, err = call("run", "m.yaml")
    assert code == 1
    assert "m.yaml:6:15: " in err
    assert not target.exists()
