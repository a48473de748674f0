"""What is wrong in files is told with its place before anything is computed, and quotes no file that is no model."""

import os
import threading

import pytest
import yaml

from tests.cli.test_cli import QUICK, QUICK_TEXT, call


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("free: [wall]", "free: [wal]", "16:53", "did you mean 'wall'"),
        ("from: transient,", "from: transent,", "15:35", "did you mean 'transient'"),
        ("{from: orbit, free", "{from: transient, free", "16:39", "put an orbit step between"),
        ("range: {wall: [0.15, 0.3]}", "range: {c: [0, 1]}", "16:67", "has no range"),
        ("[0.15, 0.3]", "[0.3, 0.15]", "16:74", "the range is empty"),
        ("max(x)", "max(y)", "12:23", "'y' is not defined"),
        ("max(x)", "x", "12:19", "state 'x' varies along the orbit"),
        ("signature: [flight]", "signature: [fligt]", "15:57", "did you mean 'flight'"),
        ("degree: 5", "degree: 0", "11:18", "greater than or equal to 1"),
        ("intervals: 14", "intervals: many", "11:32", "expected a whole number, found text"),
        ("simulate:", "simulat:", "14:25", "did you mean 'simulate'"),
        ("t_end: 60*pi", "t_end: -1", "14:43", "expected a positive time"),
        ("top: max(x)", "period: max(x)", "12:14", "'period' is a column of every table already"),
        ("top: max(x)", "wall: max(x)", "12:14", "'wall' is a parameter already"),
        (
            "  mesh: {degree",
            "  set: {omega: 0}\n  mesh: {degree",
            "11:16",
            "the forcing period is not a finite number at omega = 0",
        ),
        ("t_end: 60*pi", "t_end: 60*tau", "14:46", "'tau' is not defined"),
        ("free: [wall]", "free: [wall, wall]", "16:52", "is listed twice"),
        ("free: [wall]", "stability: 3, free: [wall]", "16:57", "expected true, false, or {multipliers: N}; found 3"),
        ("free: [wall]", "signature: [fligt], free: [wall]", "16:57", "did you mean 'flight'"),
        ("free: [wall]", "branch: switch, free: [wall, r]", "16:54", "in one free parameter; found two"),
        ("free: [wall]", "events_along: {u: maxx(x)}, free: [wall]", "16:64", "unknown function 'maxx'"),
        ("free: [wall]", "events_along: {top: max(x) - 1}, free: [wall]", "16:61", "'top' is a monitor already"),
        ("[0.15, 0.3]", "[0.25, 0.3]", "16:74", "the step starts at wall = 0.2, outside this range"),
        (
            "orbit: {from: transient, signature: [flight]}}",
            "orbit: {from: transient}, set: {wall: 2*r}}",
            "16:74",
            "the step starts at wall = 1.6, outside this range",
        ),
        ("r: 0.8", "r: 0,8", "3:48", "write a decimal point instead of the comma, 0.8"),
        ("r: 0.8", "r: .nan", "3:46", "expected a finite number, found '.nan'"),
        ("t_end: 60*pi", "t_end: nan", "14:43", "expected a finite number, found 'nan'"),
        (" - c*v - x", " - atan2(v, 1)", "5:51", "put a formula that holds one between quotation marks"),
        (" - c*v - x", " - v'(t)", "5:42", "v'(t) is the derivative at the present time"),
        (" - c*v - x", " - v''(t - 1)", "5:42", "v''(t - delay) is a second derivative"),
        (" - c*v - x", " - c*v - v'", "5:48", "v' is a derivative"),
        (" - c*v - x", " - y(t - 1)", "5:42", "'y' is not a state and has no delayed values (states: x, v)"),
        ("modes: {", "\tmodes: {", "5:1", "a tab stands here"),
    ],
)
def test_check_reports_run_errors_with_their_place(in_folder, old, new, place, words):
    assert old in QUICK_TEXT
    (in_folder / "m.yaml").write_text(QUICK_TEXT.replace(old, new, 1))
    code, _, err = call("check", "m.yaml")
    assert code == 1
    assert words in err
    assert any(line.startswith(f"m.yaml:{place}:") and words in line for line in err.splitlines()), err


def test_a_time_before_the_start_is_told_once(in_folder):
    (in_folder / "m.yaml").write_text(QUICK_TEXT.replace("t_end: 60*pi", "t_end: -3"))
    assert call("check", "m.yaml")[2].splitlines() == ["m.yaml:14:43: t_end is -3; expected a positive time"]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("r=nan", "expected a finite number, found 'nan'"),
        ("r=0,8", "'0,8' is not a number; write a decimal point, 0.8"),
        ("wall=0.5", "the step starts at wall = 0.5, outside this range"),
    ],
)
def test_what_is_set_is_checked_before_anything_is_computed(in_folder, given, words):
    (in_folder / "m.yaml").write_text(QUICK_TEXT)
    code, _, err = call("run", "m.yaml", "--set", given)
    assert code == 1
    assert words in err
    assert not (in_folder / "m.h5").exists()


SECRET = "password: [hunter2\n  - deeper"


@pytest.mark.parametrize(
    "text", [SECRET, "password: hunter2\ntoken: [1]\n", "hunter2", "- hunter2\n", "modes: hunter2"]
)
def test_a_file_that_is_no_model_is_not_quoted(in_folder, text):
    (in_folder / "secret").write_text(text)
    (in_folder / "r.yaml").write_text(yaml.safe_dump({"model": "secret", "steps": QUICK["run"]["steps"]}))
    code, out, err = call("check", "r.yaml")
    assert code == 1
    assert err.startswith("r.yaml:1:8: the model secret: is not a model file: it has no 'states'")
    assert not any(word in out + err for word in ("hunter2", "password", "token", "deeper"))


def test_a_model_that_is_not_yaml_is_told_where(in_folder):
    (in_folder / "m.yaml").write_text(QUICK_TEXT + "  - [x\n")
    (in_folder / "r.yaml").write_text(yaml.safe_dump({"model": "m.yaml", "steps": QUICK["run"]["steps"]}))
    assert call("check", "r.yaml")[2].startswith("m.yaml:17:3: not valid YAML")


@pytest.mark.parametrize("command", ["check", "info"])
@pytest.mark.parametrize("is_run", [False, True])
def test_pipes_are_read(in_folder, command, is_run):
    (in_folder / "m.yaml").write_text(QUICK_TEXT)
    text = yaml.safe_dump({"model": "m.yaml", "steps": QUICK["run"]["steps"]}) if is_run else QUICK_TEXT
    os.mkfifo(in_folder / "pipe")
    writer = threading.Thread(target=(in_folder / "pipe").write_text, args=(text,))
    writer.start()
    code, out, err = call(command, "pipe")
    writer.join()
    assert code == 0, err
    assert "quick" in out


def test_check_accepts_good_files_and_finds_shipped_ones(in_folder):
    code, out, _ = call("check", "impact_oscillator", "fig4_6")
    assert code == 0
    assert out.count("no errors") == 2


def test_a_key_of_another_kind_that_is_null_is_not_given(in_folder):
    (in_folder / "m.yaml").write_text(QUICK_TEXT.replace("{t_end: 60*pi}}", "{t_end: 60*pi}, orbit: null}"))
    assert call("check", "m.yaml")[0] == 0
