"""Figures 4.6 and 4.7 of the paper, from the shipped run files."""

import numpy as np
import pytest

from pddecont.model.document import parse_document
from pddecont.results.reader import read_results
from pddecont.steps.loading import load_plan
from pddecont.steps.run import execute
from tests.conftest import CONFIGS, ROOT
from tests.problems import PAPER_GR_K, PAPER_GR_TAU, SCHEME_GR_K


def grazings(path, name, parameter, tmp_path, **replacements):
    text = path.read_text()
    for old, new in replacements.values():
        assert old in text
        text = text.replace(old, new)
    execute(load_plan(parse_document(text, str(path))), tmp_path / f"{name}.h5")
    step = list(read_results(tmp_path / f"{name}.h5").steps.values())[-1]
    column = step.points["parameters"][:, step.meta["parameters"].index(parameter)]
    rows = [i for i in step.order if step.labels[i].startswith("GR")]
    return column[rows], step


SHORT = ("200*2*pi", "60*2*pi")


@pytest.fixture(scope="module")
def fig4_6(tmp_path_factory):
    return grazings(ROOT / "configs/fig4_6.yaml", "a", "tau_d", tmp_path_factory.mktemp("f"), short=SHORT)


def test_fig4_6_two_grazings(fig4_6):
    found, step = fig4_6
    assert np.all(np.abs(found / PAPER_GR_TAU - 1) < 0.003)
    assert np.all(step.points["admissible"] == 1)
    # Beyond both the diagram goes on by itself: to the period-1 orbit with impacts below, to the one without above.
    labels = [step.labels[i][:2] for i in step.order if step.labels[i]]
    assert labels == ["EP", "PD", "GR", "UF", "UF", "UF", "GR", "PD", "VS", "EP"]
    assert "[NC C NC C], [NC C]" in step.termination[0] and "[(NC)]" in step.termination[1]


def test_fig4_6_on_another_mesh(fig4_6, tmp_path):
    found, _ = grazings(ROOT / "configs/fig4_6.yaml", "b", "tau_d", tmp_path, short=SHORT,
                        mesh=("degree: 6, intervals: 40", "degree: 8, intervals: 26"))  # fmt: skip
    assert found == pytest.approx(fig4_6[0], abs=1e-7)


def test_fig4_6_from_the_autonomous_form(fig4_6, tmp_path):
    found, _ = grazings(ROOT / "models/impact_oscillator_autonomous.yaml", "c", "tau_d", tmp_path, short=SHORT)
    assert found == pytest.approx(fig4_6[0], abs=1e-7)


def test_fig4_7(tmp_path):
    found, step = grazings(ROOT / "configs/fig4_7.yaml", "d", "K", tmp_path, short=SHORT)
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
    plan = load_plan(parse_document(path.read_text(), str(path)))
    assert plan.warnings == ()
    assert plan.run.steps[0].kind in ("simulate", "basin")


@pytest.mark.parametrize(("name", "parameter", "expected"), [
    ("fig4_6_delay_equation", "tau_d", [3.2164416411, 4.6951888028]), ("fig4_7_delay_equation", "K", [0.1767089518]),
])  # fmt: skip
def test_the_figures_for_the_delay_equation(tmp_path, name, parameter, expected):
    """The table in docs/paper.md; tests/test_delay_equation.py finds the same numbers on other meshes."""
    found, _ = grazings(ROOT / f"configs/{name}.yaml", name, parameter, tmp_path)
    assert found == pytest.approx(expected, abs=1e-9)
