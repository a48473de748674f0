"""Brute-force diagrams: attractors against followed orbits, whoever computes them and however often the run was broken
off.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from pddecont.delay import Direct
from pddecont.errors import ResultsError, RunError
from pddecont.results import read_results
from pddecont.simulate import Method, simulate
from pddecont.steps.execution import execute
from pddecont.steps.execution import sweep as sweep_step
from pddecont.tables import describe_endings
from pddecont.tables.attractors import list_attractors, name_motion
from tests.conftest import numeric_from
from tests.runs import add_step, break_after, change, plan, run

FIG4_1 = {
    "model": "impact_oscillator",
    "effects": {"off": ["feedback"]},
    "mesh": {"degree": 8, "tol": 1e-10},
    "steps": [
        {
            "name": "diagram",
            "sweep": {
                "over": {"beta": [24, 40, 9]},
                "initial": [{"x": 0, "v": 0}, {"x": -0.26, "v": 1.74}],
                "transient": "400*2*pi/omega",
            },
        }
    ],
}


@pytest.fixture(scope="module")
def diagram(tmp_path_factory):
    return run(FIG4_1, tmp_path_factory.mktemp("sweep") / "a.h5")


def test_two_attractors_coexist_and_are_told_apart(diagram):
    step = diagram.steps["diagram"]
    rows = list_attractors(step)
    both = {r["beta"] for r in rows if r["n_NC"] == 2} & {r["beta"] for r in rows if r["n_NC"] == 1}
    # The followed orbit with two impacts exists from the fold at 26.5225 on; a start far from it finds it a little
    # later.
    assert min(both) == 28
    assert {name_motion(step, i) for i in range(len(step))} == {"period 2, 1 NC, 1 C", "period 2, 2 NC, 2 C"}
    assert all(r["share"] == 0.5 for r in rows if r["beta"] in both)
    assert all(r["turn"] == pytest.approx(2 * 2 * np.pi / 0.8, rel=1e-12) for r in rows)


def test_an_orbit_starts_from_an_attractor_by_its_label(diagram, tmp_path):
    step = diagram.steps["diagram"]
    rows = [i for i in range(len(step)) if step.points["n_segments"][i, 0] == 2]
    label, beta = step.labels[rows[2]], step.points["parameters"][rows[2], 4]
    results = run(
        add_step(FIG4_1, {"name": "o", "orbit": {"from": {"step": "diagram", "point": label}, "stability": True}}),
        tmp_path / "b.h5",
    )
    orbit = results.steps["o"]
    assert orbit.points["parameters"][0, 4] == beta
    assert orbit.orbit(0)["signature"].tobytes().decode().split() in (["NC", "C"] * 2, ["C", "NC"] * 2)
    # The returns are where the collocated orbit is at whole periods.
    times, states = orbit.orbit(0)["time"], orbit.orbit(0)["states"]
    period = 2 * np.pi / 0.8
    first = np.ceil(times[0] / period) * period
    expected = [np.interp(first + k * period, times, states[:, 0]) for k in range(2)]
    assert sorted(step.orbit(rows[2])["returns"][:, 0]) == pytest.approx(sorted(expected), abs=5e-3)
    # The same orbit from a file that was written before.
    source = {"file": str(tmp_path / "b.h5"), "step": "diagram", "point": label}
    short = change(FIG4_1, "steps.0.sweep.over.beta", [30, 31, 1])
    other = run(add_step(short, {"name": "o", "orbit": {"from": source}}), tmp_path / "c.h5")
    assert other.steps["o"].points["period"][0] == pytest.approx(orbit.points["period"][0], rel=1e-12)
    assert other.steps["o"].points["parameters"][0, 4] == beta


def test_an_attractor_must_be_named(diagram, tmp_path):
    with pytest.raises(Exception, match="say which"):
        run(add_step(FIG4_1, {"name": "o", "orbit": {"from": "diagram"}}), tmp_path / "b.h5")
    short = change(FIG4_1, "steps.0.sweep.over.beta", [24, 40, 2])
    with pytest.raises(ResultsError, match="has no point 'A999'"):
        run(add_step(short, {"name": "o", "orbit": {"from": {"step": "diagram", "point": "A999"}}}), tmp_path / "b.h5")


def same(a, b, name="diagram"):
    """Whether two steps hold the same numbers to the last bit."""
    a, b = a.steps[name], b.steps[name]
    assert describe_endings(a) == describe_endings(b)
    for group in ("points", "orbits"):
        for key, column in getattr(a, group).items():
            assert np.array_equal(column, getattr(b, group)[key], equal_nan=column.dtype.kind == "f"), key
    return True


def test_the_answer_does_not_depend_on_the_number_of_workers(diagram, tmp_path):
    execute(plan(FIG4_1), tmp_path / "w.h5", workers=3)
    assert same(diagram, read_results(tmp_path / "w.h5"))


@pytest.mark.parametrize("broken_after", [1, 3])
def test_a_broken_run_goes_on_to_the_same_numbers(diagram, tmp_path, monkeypatch, broken_after):
    made = plan(FIG4_1)
    monkeypatch.setattr(sweep_step, "CHUNK", 4)
    whole = break_after(monkeypatch, sweep_step, broken_after)
    with pytest.raises(KeyboardInterrupt):
        execute(made, tmp_path / "r.h5")
    part = read_results(tmp_path / "r.h5").steps["diagram"]
    assert 0 < len(part) < len(diagram.steps["diagram"])
    monkeypatch.setattr(sweep_step, "map_in_order", whole)
    execute(made, tmp_path / "r.h5", resume=True)
    execute(made, tmp_path / "once.h5")
    assert same(read_results(tmp_path / "once.h5"), read_results(tmp_path / "r.h5"))


def test_an_attractor_carried_along_is_lost_at_the_fold(tmp_path):
    """Carried down, the orbit with two impacts lasts to the fold of its branch at beta = 26.5224937149 (docs/paper)."""
    carried = {
        "over": {"beta": [26, 29, 13]},
        "initial": [{"x": -0.26, "v": 1.74}],
        "carry": "down",
        "transient": "400*2*pi/omega",
    }
    step = run(change(FIG4_1, "steps.0.sweep", carried), tmp_path / "c.h5").steps["diagram"]
    two = step.points["parameters"][step.points["n_segments"][:, 0] == 2, 4]
    assert two.min() == 26.75
    assert np.all(step.points["direction"] == -1)
    with_one = step.points["parameters"][step.points["n_segments"][:, 0] == 1, 4]
    assert sorted(with_one) == [26.0, 26.25, 26.5]


def test_a_delay_equation_carried_along_keeps_its_past(tmp_path):
    text = {
        "model": "impact_oscillator",
        "steps": [
            {"name": "up", "sweep": {"over": {"K": [0.15, 0.19, 9]}, "transient": "600*2*pi/omega", "carry": "up"}},
            {"name": "anew", "sweep": {"over": {"K": [0.15, 0.19, 9]}, "transient": "600*2*pi/omega"}},
        ],
    }
    results = run(text, tmp_path / "d.h5")
    # The reverse period doubling lies at K = 0.1769069625, and the wall is left at 0.1774776777 (docs/paper.md).
    for name in ("up", "anew"):
        step = results.steps[name]
        gain = step.points["parameters"][:, 5]
        assert np.all(step.points["period"][gain < 0.1768] == 2)
        assert np.all(step.points["period"][gain > 0.1776] == 1)
    for a, b in zip(results.steps["up"].orbits["returns"], results.steps["anew"].orbits["returns"], strict=True):
        assert np.min(np.abs(results.steps["anew"].orbits["returns"][:, 0] - a[0])) < 1e-5, (a, b)


def test_a_delay_that_is_carried_along_finds_its_longer_past(tmp_path):
    """tau goes from 0.2 to 1.4 after four periods, before anything has settled: the returns are those of one simulation
    that does so.
    """
    text = {
        "name": "m",
        "states": ["x"],
        "parameters": {"tau": 0.2, "w": 1},
        "forcing": {"period": "2*pi/w"},
        "modes": {"m": {"x'": "-x(t - tau) + cos(w*t)"}},
        "initial": {"x": 0.3},
        "run": {
            "steps": [
                {"name": "diagram", "sweep": {"over": {"tau": [0.2, 1.4, 2]}, "carry": "up", "transient": "8*pi"}}
            ]
        },
    }
    step = run(text, tmp_path / "t.h5").steps["diagram"]
    numeric = numeric_from({key: value for key, value in text.items() if key != "run"})
    period = 2 * np.pi
    once = simulate(
        numeric,
        np.array([0.2, 1.0]),
        Direct(),
        8 * period,
        Method(1e-11, 1e-13),
        schedule=[(4 * period, np.array([1.4, 1.0]))],
    )
    assert step.orbit(0)["returns"][:, 0] == pytest.approx(once(np.array([3, 4]) * period)[:, 0], abs=1e-7)
    assert step.orbit(1)["returns"][:, 0] == pytest.approx(once(np.array([7, 8]) * period)[:, 0], abs=1e-7)


def test_what_fails_is_kept_with_its_reason(tmp_path):
    text = {
        "name": "m",
        "states": ["x", "v"],
        "parameters": {"g": 9.81, "r": 0.8},
        "modes": {"m": {"x'": "v", "v'": "-g"}},
        "events": {"hit": "x"},
        "resets": {"bounce": {"v": "-r*v"}},
        "segments": {"s": {"mode": "m", "event": "hit", "direction": "falling", "reset": "bounce", "to": "m"}},
        "initial": {"x": 1},
        "run": {
            "steps": [
                {"name": "diagram", "sweep": {"over": {"g": [5, 10, 3]}, "section": {"event": "hit"}, "transient": 100}}
            ]
        },
    }
    step = run(text, tmp_path / "z.h5").steps["diagram"]
    assert step.labels == ("", "", "")
    assert all("accumulate at t" in r["note"] for r in list_attractors(step))


def test_a_motion_that_leaves_the_section_for_good_is_told(tmp_path):
    """x = exp(-0.01 t) cos(t) rises through h for the last time where it is below h a turn later."""
    text = {
        "name": "m",
        "states": ["x", "y"],
        "parameters": {"h": 0.52},
        "modes": {"m": {"x'": "-0.01*x - y", "y'": "x - 0.01*y"}},
        "events": {"hit": "x - h"},
        "resets": {"none": {}},
        "segments": {"s": {"mode": "m", "event": "hit", "direction": "rising", "reset": "none", "to": "m"}},
        "initial": {"x": 1},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {"over": {"h": [0.52, 0.52, 1]}, "section": {"event": "hit"}, "transient": 500},
                }
            ]
        },
    }
    (row,) = list_attractors(run(text, tmp_path / "z.h5").step("diagram"))
    last = brentq(lambda t: np.exp(-0.01 * t) * np.cos(t) - 0.52, 19 * np.pi, 20 * np.pi - 0.1)
    assert row["note"] == f"the motion no longer returns to the section after t = {last:.6g}"


def test_starts_at_random_are_the_same_every_time(tmp_path):
    at_random = {
        "over": {"beta": [60, 60, 1]},
        "random": {"number": 12, "box": {"x": [-1, 1], "v": [-1.5, 1.5]}},
        "transient": "400*2*pi/omega",
    }
    text = change(FIG4_1, "steps.0.sweep", at_random)
    step = run(text, tmp_path / "a.h5").steps["diagram"]
    assert len(step) == 2
    assert step.points["share"].sum() == pytest.approx(1.0)
    assert same(run(text, tmp_path / "a.h5"), run(text, tmp_path / "b.h5"))


def test_starts_at_random_do_not_depend_on_the_order_of_names():
    """A file that is written of what another holds may name states in another order."""
    starts = []
    for names in (("x", "v"), ("v", "x")):
        box = {name: {"x": [-1, 1], "v": [-2, 2]}[name] for name in names}
        sweep = {"over": {"beta": [60, 60, 1]}, "random": {"number": 3, "box": box}, "transient": "400*2*pi/omega"}
        checked = plan(change(FIG4_1, "steps.0.sweep", sweep))
        ((_, chunk),) = sweep_step.list_chunks(checked, checked.steps[0].settings)
        starts.append([start.states for start in chunk.points[0].starts])
    assert np.array_equal(*starts)


def test_two_parameters(tmp_path):
    text = change(FIG4_1, "steps.0.sweep.over", {"beta": [28, 60, 2], "a": [0.85, 0.95, 3]})
    text = change(text, "steps.0.sweep.transient", "200*2*pi/omega")
    step = run(text, tmp_path / "t.h5").steps["diagram"]
    cells = sorted(set(step.points["cell"]))
    assert cells == list(range(6))
    at = {int(c): tuple(step.points["parameters"][list(step.points["cell"]).index(c), [4, 1]]) for c in cells}
    assert at[1] == (60.0, 0.85)
    assert at[2] == (28.0, pytest.approx(0.9))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"random": {"number": 2, "box": {"x": [3, 1]}}}, "range is empty: 3 is not below 1"),
        ({"over": {"omega": [-1, 1, 3]}}, "the forcing period is -6.28319 at omega = -1; expected a positive number"),
    ],
)
def test_what_cannot_be_is_said_before_anything_is_computed(keys, message):
    with pytest.raises(RunError) as error:
        plan(change(FIG4_1, "steps.0.sweep", {**FIG4_1["steps"][0]["sweep"], **keys}))
    assert message in str(error.value)


def test_histories_of_a_sweep_are_one(tmp_path):
    text = change(FIG4_1, "steps.0.sweep.initial.0", {"x": 0, "history": {"x": 1}})
    with pytest.raises(RunError, match="share one history"):
        plan(text)


def test_points_of_a_sobol_sequence_have_parameters_and_states_of_their_own():
    over = {"G": [0.4, 1.2, 8]}
    random = {"number": 2, "seed": 3, "box": {"y": [0, 2], "v": ["-G", "G"]}, "spread": "sobol"}
    data = {
        "model": "bouncing_ball",
        "steps": [{"name": "s", "sweep": {"over": over, "random": random, "transient": 100}}],
    }
    checked = plan(data)
    points = [p for _, chunk in sweep_step.list_chunks(checked, checked.steps[0].settings) for p in chunk.points]
    values = np.array([p.p[0] for p in points])
    states = np.array([[start.states for start in p.starts] for p in points])
    assert states.shape == (8, 2, 2)
    # One point in each eighth of every range: what a Sobol sequence is for.
    for column, low, width in (
        (values, 0.4, 0.8),
        *((states[:, k, 0], 0.0, 2.0) for k in range(2)),
        *((states[:, k, 1], -values, 2 * values) for k in range(2)),
    ):
        assert sorted(np.floor(8 * (column - low) / width)) == list(range(8))
    with pytest.raises(RunError, match="no order to be carried along"):
        plan(change(data, "steps.0.sweep", {**data["steps"][0]["sweep"], "carry": "up"}))
