"""Figures 4.6 and 4.7 of the paper, from the shipped run files."""

import numpy as np
import pytest
import yaml

from pddecont.model import parse_document
from pddecont.steps import load_run_plan
from pddecont.tables import describe_endings
from tests.conftest import CONFIGS, ROOT
from tests.problems import PAPER_GR_K, PAPER_GR_TAU, SCHEME_GR_K
from tests.runs import run

AUTONOMOUS = ROOT / "models" / "impact_oscillator_autonomous.yaml"
FIG4_6 = ROOT / "configs" / "fig4_6.yaml"


def grazings(path, parameter, folder, *, short=False, mesh=None):
    """Return the grazings on the last branch of a shipped run, and the step.

    ``short`` simulates for a shorter time.
    """
    data = yaml.safe_load(path.read_text())
    whole = data if "steps" in data else data["run"]
    if short:
        transient = whole["steps"][0]["simulate"]
        assert transient["t_end"].startswith("200*2*pi")
        transient["t_end"] = transient["t_end"].replace("200", "60")
    if mesh:
        whole["mesh"] = mesh
    if isinstance(data.get("model"), str):
        data["model"] = str((path.parent / data["model"]).resolve())
    step = list(run(data, folder / "a.h5").steps.values())[-1]
    column = step.points["parameters"][:, step.meta["parameters"].index(parameter)]
    rows = [i for i in step.order if step.labels[i].startswith("GR")]
    return column[rows], step


@pytest.fixture(scope="module")
def fig4_6(tmp_path_factory):
    return grazings(FIG4_6, "tau_d", tmp_path_factory.mktemp("f"), short=True)


def test_fig4_6_two_grazings(fig4_6):
    found, step = fig4_6
    assert np.all(np.abs(found / PAPER_GR_TAU - 1) < 0.003)
    assert np.all(step.points["admissible"] == 1)
    # Beyond both the diagram goes on by itself: to the period-1 orbit with impacts below, to the one without above.
    kinds = [step.labels[i][:2] for i in step.order if step.labels[i]]
    assert kinds == ["EP", "PD", "GR", "UF", "UF", "UF", "GR", "PD", "VS", "EP"]
    assert "[NC C NC C], [NC C]" in describe_endings(step)[0] and "[(NC)]" in describe_endings(step)[1]


def test_fig4_6_on_another_mesh(fig4_6, tmp_path):
    found, _ = grazings(FIG4_6, "tau_d", tmp_path, short=True, mesh={"degree": 8, "intervals": 26})
    assert found == pytest.approx(fig4_6[0], abs=1e-7)


def test_fig4_6_from_the_autonomous_form(fig4_6, tmp_path):
    found, _ = grazings(AUTONOMOUS, "tau_d", tmp_path, short=True)
    assert found == pytest.approx(fig4_6[0], abs=1e-7)


def test_fig4_7(tmp_path):
    found, step = grazings(ROOT / "configs" / "fig4_7.yaml", "K", tmp_path, short=True)
    assert found == pytest.approx([SCHEME_GR_K], abs=1e-9)
    assert found == pytest.approx([PAPER_GR_K], rel=0.003)
    contact = step.points["monitors"][step.order, 0]
    one = [list(step.order).index(step.row(label)) for label in ("GR1", "PD1", "VS1")]
    assert np.all(np.diff(contact[3 : one[0] + 1]) < 0)
    assert contact[0] > 0.5
    assert contact[one[0]] < 0.14
    assert np.all(np.diff(contact[one[1] : one[2] + 1]) < 0)
    assert np.all(contact[one[2] :] == 0)
    column = step.points["parameters"][:, step.meta["parameters"].index("K")]
    assert column[step.row("VS1")] == pytest.approx(0.1753370132, abs=1e-9)


@pytest.mark.parametrize("path", CONFIGS, ids=lambda p: p.stem)
def test_every_run_file_is_in_order(path):
    plan = load_run_plan(parse_document(path.read_text(), str(path)))
    assert plan.warnings == ()
    assert plan.steps[0].kind in ("simulate", "basin", "equilibrium")


@pytest.mark.parametrize(
    ("name", "parameter", "expected"),
    [("fig4_6_delay_equation", "tau_d", [3.2164416411, 4.6951888028]), ("fig4_7_delay_equation", "K", [0.1767089518])],
)
def test_the_figures_for_the_delay_equation(tmp_path, name, parameter, expected):
    """The table in docs/paper.md; tests/test_delay_equation.py finds the same numbers on other meshes."""
    found, _ = grazings(ROOT / "configs" / f"{name}.yaml", parameter, tmp_path)
    assert found == pytest.approx(expected, abs=1e-9)
