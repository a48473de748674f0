"""A kind of special point and a kind of step, each defined here and nowhere else: found, recorded, resumed, shown.

Phase resonance (PR): the response of a driven oscillator lags its drive by a quarter of a turn. The linear oscillator
x'' + c x' + k x = cos(w t) has x = Re e^(i w t)/(k - w^2 + i c w), so that no part of x is in step with the drive where
w = sqrt(k), whatever the damping; and its first harmonic has the amplitude 1/|k - w^2 + i c w|.
"""

import json
import signal
import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest
from pydantic import Field

from pddecont.bifurcation import SpecialPointKind, forget_kind, register_kind
from pddecont.continuation import TestFunction as BranchTest
from pddecont.model import Strict
from pddecont.orbit import parse_monitor
from pddecont.plot import Drawing, View, forget_view, register_view
from pddecont.reasons import make_reason
from pddecont.results import Column, StepFormat, read_results
from pddecont.runfile import From, Holding
from pddecont.steps import StepKind, forget_step_kind, register_step_kind
from pddecont.steps.execution import execute, report_done
from pddecont.tables import register_ending, register_words
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.runs import change, labels, parameter, plan, to_yaml

# ---- a kind of special point


def lag(at):
    """Return the part of x that is in step with the drive."""
    return parse_monitor(at.orbit.numeric, "in_step", "mean(x*cos(w*t))").evaluate(at.orbit)


@dataclass(frozen=True, eq=False)
class QuarterTurn:
    """The lag as a defining function."""

    kind: str = "PR"

    def evaluate(self, at):
        return lag(at)

    def update_at(self, at):
        return self


PHASE_RESONANCE = SpecialPointKind(
    "PR",
    "phase resonance",
    on_branches=True,
    branch_tests=lambda at, settings: [BranchTest("PR", lambda point: lag(point.at), reason=make_reason("quarter"))],
    define=lambda at, settings, reason: QuarterTurn(),
)

# ---- a kind of step


class Spectrum(Strict):
    """Harmonics of a recorded orbit."""

    from_: From = Field(alias="from", description="an orbit step")
    harmonics: int = Field(3, ge=1, description="how many")


def resolve_spectrum(given):
    if given.source_holds not in (None, Holding.ORBIT):
        given.add_error(("from",), f"'{given.source.step}' holds no orbit")
    return given.body.harmonics


SPECTRUM = StepFormat(
    "spectrum", {"harmonic": Column("i8"), "frequency": Column("f8"), "amplitude": Column("f8", ("states",))}
)


def run_spectrum(context, step, recorded):
    """Record one harmonic after another."""
    _, source = context.read_source(step.source)
    rows, period = source.orbit(0), float(source.points["period"][0])
    t, x = rows["time"], rows["states"]
    kept = 0 if recorded is None else len(recorded)
    with context.open_step(step, SPECTRUM, {}, recorded=recorded, kept=kept) as writer:
        for n in range(kept + 1, step.settings + 1):
            w = 2 * np.pi * n / period
            # Collocated orbits are smooth between their points: Simpson's rule on a spline of them.
            fine = np.linspace(t[0], t[-1], 2001)
            wave = np.array([np.interp(fine, t, column) for column in x.T]) * np.exp(-1j * w * fine)
            writer.append({"harmonic": n, "frequency": w, "amplitude": np.abs(np.trapezoid(wave, fine)) * 2 / period})
        writer.terminate(make_reason("analysed", number=step.settings))
    report_done(context, step)


SPECTRUM_STEP = StepKind(
    "spectrum", Spectrum, resolve_spectrum, SPECTRUM, "tests.test_extension:run_spectrum", resumes=True
)


def register():
    """Make both kinds known, and the words for what they record."""
    register_kind(PHASE_RESONANCE)
    register_step_kind(SPECTRUM_STEP)
    register_words("quarter", lambda values: "lags by a quarter turn")
    register_ending("spectrum", lambda step, ending: f"{ending.values['number']} harmonics found")


@pytest.fixture(scope="module", autouse=True)
def registered():
    register()
    yield
    forget_kind("PR")
    forget_step_kind("spectrum")


# ---- what is done with them

DRIVEN = {
    "name": "driven",
    "states": ["x", "v"],
    "parameters": {"w": 0.7, "k": 1, "c": 0.3},
    "forcing": {"period": "2*pi/w"},
    "modes": {"m": {"x'": "v", "v'": "cos(w*t) - c*v - k*x"}},
    "run": {
        "mesh": {"degree": 7, "tol": 1e-11},
        "monitors": {"top": "max(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 300}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "lines", "spectrum": {"from": "o", "harmonics": 5}},
            {"name": "branch", "continue": {"from": "o", "free": ["w"], "range": {"w": [0.5, 1.6]}}},
            {
                "name": "curve",
                "continue": {
                    "from": {"step": "branch", "point": "PR1"},
                    "free": ["w", "k"],
                    "range": {"w": [0.5, 1.6], "k": [0.5, 2]},
                },
            },
        ],
    },
}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("extension")
    (folder / "driven.yaml").write_text(to_yaml(DRIVEN))
    code, _, err = call("run", folder / "driven.yaml", "-o", folder / "driven.h5")
    assert code == 0, err
    return folder / "driven.h5", err


def test_the_point_is_located_and_followed(done):
    results = read_results(done[0])
    branch, curve = results.step("branch"), results.step("curve")
    assert labels(branch) == ["PR1"]
    assert parameter(branch, "w", "PR1") == pytest.approx(1.0, abs=1e-10)
    w, k = parameter(curve, "w"), parameter(curve, "k")
    assert len(w) > 5
    assert w == pytest.approx(np.sqrt(k), abs=1e-9)
    assert (k.min(), k.max()) == (pytest.approx(0.5), pytest.approx(2.0))


def test_the_step_is_recorded(done):
    step = read_results(done[0]).step("lines")
    assert step.done
    assert step.points["harmonic"].tolist() == [1, 2, 3, 4, 5]
    amplitude = 1 / abs(1 - 0.7**2 + 0.3j * 0.7)
    # Lines between the orbit's points: their error is that of the drawing, far above the orbit's own.
    assert step.points["amplitude"][0] == pytest.approx([amplitude, 0.7 * amplitude], rel=1e-2)
    assert np.all(step.points["amplitude"][1:] < 1e-2 * amplitude)


KILLED = """
import os, signal, sys
from pathlib import Path
from pddecont.results import StepWriter
from tests import test_extension as extension
extension.register()
append, count = StepWriter.append, [0]
def appended(self, *row):
    append(self, *row)
    count[0] += self.name == sys.argv[2]
    if count[0] == int(sys.argv[3]):
        os.kill(os.getpid(), signal.SIGKILL)
StepWriter.append = appended
extension.execute(extension.plan(extension.DRIVEN), Path(sys.argv[1]))
"""


@pytest.mark.parametrize(("name", "kept"), [("lines", 3), ("branch", 4), ("curve", 3)])
def test_both_resume_after_a_kill(tmp_path, name, kept):
    path = tmp_path / "killed.h5"
    killed = subprocess.run([sys.executable, "-c", KILLED, path, name, str(kept)], cwd=ROOT, check=False, timeout=300)
    assert killed.returncode == -signal.SIGKILL
    part = read_results(path).step(name)
    assert (len(part), part.done) == (kept, False)
    execute(plan(DRIVEN), path, resume=True)
    execute(plan(DRIVEN), tmp_path / "whole.h5")
    resumed, once = (read_results(file).steps.values() for file in (path, tmp_path / "whole.h5"))
    for step, whole in zip(resumed, once, strict=True):
        assert step.labels == whole.labels
        assert step.endings == whole.endings
        for key, values in whole.points.items():
            assert np.array_equal(step.points[key], values, equal_nan=values.dtype.kind == "f"), key


def test_both_are_known_where_the_run_is_computed(tmp_path):
    """Other processes do not know them."""
    for workers in (1, 3):
        execute(plan(DRIVEN), tmp_path / f"{workers}.h5", workers=workers)
    assert (tmp_path / "1.h5").read_bytes() == (tmp_path / "3.h5").read_bytes()


def test_both_are_exported(done):
    rows = json.loads(call("export", done[0], "--step", "lines", "--format", "json")[1])
    assert list(rows[0]) == ["index", "label", "harmonic", "frequency", "amplitude_x", "amplitude_v", "note"]
    assert [row["frequency"] for row in rows] == pytest.approx([0.7 * n for n in range(1, 6)])
    rows = json.loads(call("export", done[0], "--step", "branch", "--table", "special", "--format", "json")[1])
    assert [(row["kind"], row["note"]) for row in rows if row["kind"] == "PR"] == [("PR", "lags by a quarter turn")]


def test_both_are_in_info_and_report(done):
    text = call("info", done[0])[1]
    assert "5 harmonics found" in text
    assert "PR1" in text
    assert "curve: PR (phase resonance)" in text
    assert call("report", done[0], "-o", done[0].with_suffix(".html"))[0] == 0
    page = done[0].with_suffix(".html").read_text()
    for words in ("PR1", "phase resonance", "lags by a quarter turn", "5 harmonics found", "amplitude_x"):
        assert words in page, words


def test_both_are_told_while_they_are_computed(done):
    assert "5 harmonics found" in done[1]
    assert "PR1" in done[1]


@pytest.mark.parametrize(("options", "drawn"), [(["--step", "lines"], "harmonic"), (["--step", "branch"], "PR1")])
def test_both_are_drawn(done, tmp_path, options, drawn):
    assert call("plot", done[0], *options, "-o", tmp_path / "p.svg")[0] == 0
    assert drawn in (tmp_path / "p.svg").read_text()


def test_a_view_of_ones_own_is_drawn(done, tmp_path):
    register_view(View("lines", "harmonics", "tests.test_extension:DRAWING", places={"spectrum": 0}))
    try:
        assert call("plot", done[0], "--step", "lines", "-o", tmp_path / "p.svg")[0] == 0
    finally:
        forget_view("lines")
    assert "own view" in (tmp_path / "p.svg").read_text()


def draw(steps, request):
    from matplotlib.figure import Figure

    figure = Figure()
    axes = figure.add_subplot()
    axes.stem(steps[-1].points["harmonic"], steps[-1].points["amplitude"][:, 0])
    axes.set_title("own view")
    return figure


DRAWING = Drawing(draw)


def test_what_is_wrong_with_a_step_is_said_at_its_place(tmp_path):
    (tmp_path / "m.yaml").write_text(to_yaml(change(DRIVEN, "run.steps.2.spectrum", {"from": "t", "harmonics": 0})))
    code, _, err = call("check", tmp_path / "m.yaml")
    assert code == 1
    assert "greater than or equal to 1" in err
    (tmp_path / "m.yaml").write_text(to_yaml(change(DRIVEN, "run.steps.2.spectrum", {"from": "t"})))
    code, _, err = call("check", tmp_path / "m.yaml")
    assert (code, "'t' holds no orbit" in err) == (1, True)


def test_a_name_is_given_once():
    with pytest.raises(ValueError, match="'PR' already"):
        register_kind(PHASE_RESONANCE)
    with pytest.raises(ValueError, match="'spectrum' already"):
        register_step_kind(SPECTRUM_STEP)


def test_a_file_with_a_kind_of_step_that_is_not_known_is_refused(done):
    code = "import sys; from pddecont.cli import main; main(sys.argv[1:])"
    arguments = [sys.executable, "-c", code, "info", str(done[0])]
    shown = subprocess.run(arguments, capture_output=True, text=True, check=False, cwd=ROOT)
    assert shown.returncode == 1
    assert "step 'lines': steps of kind 'spectrum' are not known (kinds: simulate" in shown.stderr
