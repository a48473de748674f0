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


def explore(over, folder, set_=None):
    """Return what exploring the impact oscillator over its parameters finds."""
    step = {"name": "all", "set": set_ or {}, "explore": {"over": over}}
    data = {"model": "impact_oscillator", "delay": {"method": "chain", "order": 2, "n": 15}, "steps": [step]}
    return run(data, folder / "a.h5")


def list_special(results, name, *kinds):
    """Return the values of a parameter at all special points of some kinds on branches of orbits, by kind."""
    found = {kind: [] for kind in kinds}
    for step in results.steps.values():
        if step.kind == "continue" and not step.meta["curve"]:
            values = step.points["parameters"][:, step.meta["parameters"].index(name)]
            for row in range(len(step)):
                if step.kind_of(row) in kinds:
                    found[step.kind_of(row)].append(float(values[row]))
    return found


@pytest.mark.slow
def test_the_branches_of_figures_4_2_and_4_7_and_the_plane_of_4_8_are_explored(tmp_path):
    """What configs/fig4_2.yaml and fig4_7.yaml find, and curves through what fig4_6.yaml finds: docs/paper.md."""
    results = explore({"K": [0, 0.3], "tau_d": [0.5, 7.5]}, tmp_path)
    found = list_special(results, "K", "GR", "PD", "LP")
    # The grazing of the period-2 orbit, and that of the period-1 orbit, which leaves the wall.
    assert found["GR"] == pytest.approx([0.1747469554, 0.1753370132], abs=1e-8)
    assert found["PD"] == pytest.approx([0.1748921188, 0.1748921188], abs=1e-8)
    assert found["LP"] == pytest.approx([0.0038365162], abs=1e-8)
    (ending,) = results.steps["all"].endings
    assert ending.values["n_explained"] == ending.values["n_motions"]
    curves = [step for step in results.steps.values() if step.meta.get("curve")]
    assert sorted(step.meta["curve"] for step in curves) == ["GR", "GR", "LP", "PD", "PD", "TR"]
    assert len(results.steps["all"].meta["meetings"]) == 2
    crossed = []
    for step in curves:
        k, tau = (step.points["parameters"][step.order, step.meta["parameters"].index(n)] for n in ("K", "tau_d"))
        for i in np.flatnonzero((k[:-1] - 0.12) * (k[1:] - 0.12) < 0):
            crossed.append(np.interp(0.12, np.sort(k[i : i + 2]), tau[i : i + 2][np.argsort(k[i : i + 2])]))
    # Chords between points of the curves; configs/fig4_6.yaml, and the closed form of the period-1 orbit.
    for known in (3.1986107136, 4.6631237051, 4.6692266812):
        assert np.min(np.abs(np.array(crossed) - known)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("over", "set_", "kind", "known"),
    [
        ({"tau_d": [3, 5]}, {}, "GR", [3.1986107136, 4.6631237051, 4.6692266812]),
        ({"beta": [20, 100]}, {"K": 0}, "LP", [26.5224937149]),
    ],
)
def test_the_branches_of_figures_4_6_and_4_1_are_explored(tmp_path, over, set_, kind, known):
    results = explore(over, tmp_path, set_)
    (name,) = over
    assert sorted(list_special(results, name, kind)[kind]) == pytest.approx(known, abs=1e-7)
