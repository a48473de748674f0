"""Orbits from files of times and states: rough ones converge to the orbit that they are near."""

import math

import numpy as np
import pytest
import yaml

from pddecont.cli.export import to_csv
from pddecont.errors import ConvergenceError, ResultsError, RunError
from pddecont.results import read_results
from pddecont.steps.execution import execute
from pddecont.tables import make_table
from tests.runs import multipliers, plan, run

FINE = {"degree": 8, "tol": 1e-11}
# validation.md of the paper's closed forms: period of x' = -2 x(t - 1) (1 + x).
WRIGHT_PERIOD = 4.4027436513
NO_DOUBT = {"verify": False}


def write_rough(path, step, row, *, digits=3, n=30, columns=("segment",)):
    """Write an orbit with few digits: about ``n`` of its rows, those at the ends of segments, and some columns."""
    rows = make_table(step, "orbit", row)
    stride = max(1, len(rows) // n)
    kept = [
        r
        for i, r in enumerate(rows)
        if i % stride == 0 or i + 1 == len(rows) or r["segment"] != rows[i - 1]["segment"]
        or r["segment"] != rows[i + 1]["segment"]
    ]  # fmt: skip
    names = [name for name in rows[0] if name != "segment" or name in columns]
    rounded = [{k: round(r[k], digits) if isinstance(r[k], float) else r[k] for k in names} for r in kept]
    path.write_text(to_csv(rounded))
    return len(kept)


def write_rows(path, header, rows):
    path.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]))


def from_file(model, path, name="out.h5", *, source=None, step=None, **keys):
    """Return the orbit step of a run that starts from a file."""
    orbit = {"from": {"trajectory": str(path), **(source or {})}, **(step or {})}
    steps = [{"name": "orbit", "orbit": orbit}]
    run_keys = {"mesh": FINE, "steps": steps, **keys}
    whole = {**model, "run": run_keys} if isinstance(model, dict) else {"model": model, **run_keys}
    return run(whole, path.parent / name).step("orbit")


@pytest.fixture(scope="module")
def doubled(tmp_path_factory):
    """Orbits of Mackey and Glass' equation beyond a period doubling: they are unstable."""
    steps = [
        {"name": "transient", "simulate": {"t_end": 300}},
        {"name": "start", "orbit": {"from": "transient"}},
        {"name": "branch", "continue": {"from": "start", "free": ["tau"], "range": {"tau": [1.2, 1.5]}, **NO_DOUBT}},
        {"name": "orbit", "orbit": {"from": {"step": "branch", "point": "EP2"}, "stability": True}},
    ]
    keys = {"set": {"tau": 1.2}, "mesh": FINE, "monitors": {"highest": "max(x)", "lowest": "min(x)"}, "steps": steps}
    return run({"model": "mackey_glass", **keys}, tmp_path_factory.mktemp("doubled") / "a.h5").step("orbit")


def test_a_rough_unstable_orbit_converges_to_the_orbit(doubled, tmp_path):
    path = tmp_path / "rough.csv"
    assert write_rough(path, doubled, 0, columns=()) <= 45
    keys = {"set": {"tau": 1.5}, "monitors": {"highest": "max(x)", "lowest": "min(x)"}}
    found = from_file("mackey_glass", path, step={"stability": True}, **keys)
    (exact,), (row,) = make_table(doubled, "points", None), make_table(found, "points", None)
    assert row["stable"] is False
    assert row["verified"] is True
    for name in ("period", "highest", "lowest"):
        assert row[name] == pytest.approx(exact[name], abs=1e-9)
    assert multipliers(found)[1] == pytest.approx(multipliers(doubled)[1], abs=1e-7)


def test_the_programs_own_export_is_the_orbit_again(doubled, tmp_path):
    path = tmp_path / "own.csv"
    path.write_text(to_csv(make_table(doubled, "orbit", 0)))
    found = from_file("mackey_glass", path, set={"tau": 1.5}, monitors={"highest": "max(x)", "lowest": "min(x)"})
    assert found.points["n_iterations"][0] <= 2
    assert found.points["period"][0] == pytest.approx(doubled.points["period"][0], abs=1e-9)
    assert found.points["monitors"][0] == pytest.approx(doubled.points["monitors"][0], abs=1e-9)


def write_sine(path, period=4.0, turns=1, n=20):
    rows = [(round(period * i / n, 3), round(math.sin(2 * math.pi * turns * i / n), 2)) for i in range(n + 1)]
    write_rows(path, "time,x", rows)


@pytest.mark.parametrize("delay", [{"method": "direct"}, {"method": "chebyshev", "n": 24}])
def test_a_rough_sine_becomes_the_orbit_of_wrights_equation(delay, tmp_path):
    write_sine(tmp_path / "sine.csv")
    found = from_file("wright", tmp_path / "sine.csv", delay=delay)
    assert found.points["period"][0] == pytest.approx(WRIGHT_PERIOD, abs=1e-9)


def test_an_equilibrium_is_no_orbit(tmp_path):
    write_sine(tmp_path / "sine.csv")
    with pytest.raises(ConvergenceError, match=r"near .*sine.csv is an equilibrium and no periodic orbit"):
        from_file("wright", tmp_path / "sine.csv", set={"alpha": 1.2})


def test_an_orbit_twice_over_is_not_recorded(tmp_path):
    write_sine(tmp_path / "two.csv", 8.8, 2, 40)
    with pytest.raises(ConvergenceError, match=r"is an orbit of period 4.40274365\d, 2 times over"):
        from_file("wright", tmp_path / "two.csv")


@pytest.fixture(scope="module")
def impacts(tmp_path_factory):
    """An orbit with impacts beyond a period doubling: it is unstable."""
    branch = {"from": "start", "free": ["omega"], "range": {"omega": [2, 2.35]}, **NO_DOUBT}
    steps = [
        {"name": "transient", "simulate": {"t_end": 300}},
        {"name": "start", "orbit": {"from": "transient"}},
        {"name": "branch", "continue": branch},
        {"name": "orbit", "orbit": {"from": {"step": "branch", "point": "EP2"}, "stability": True}},
    ]
    path = tmp_path_factory.mktemp("impacts") / "a.h5"
    return run({"model": "wall_oscillator", "mesh": FINE, "steps": steps}, path).step("orbit")


@pytest.mark.parametrize("columns", [("segment",), ()])
def test_a_rough_unstable_orbit_with_impacts_converges_to_the_orbit(impacts, columns, tmp_path):
    path = tmp_path / "rough.csv"
    write_rough(path, impacts, 0, columns=columns)
    source = {"signature": ["flight"]}
    found = from_file("wall_oscillator", path, source=source, step={"stability": True}, set={"omega": 2.35})
    assert make_table(found, "points", None)[0]["stable"] is False
    # It begins with the impact: time, in the forcing's period, and state.
    assert found.orbit(0)["time"][0] == pytest.approx(impacts.orbit(0)["time"][0], abs=1e-9)
    assert found.orbit(0)["states"][0] == pytest.approx(impacts.orbit(0)["states"][0], abs=1e-9)
    assert np.max(np.abs(multipliers(found))) == pytest.approx(np.max(np.abs(multipliers(impacts))), abs=1e-7)


def test_rows_of_a_forced_model_may_begin_anywhere_and_periods_later(impacts, tmp_path):
    path, period = tmp_path / "later.csv", 2 * math.pi / 2.35
    rows = [(r["t"], r["x"], r["v"]) for r in make_table(impacts, "orbit", 0)]
    rows = [row for i, row in enumerate(rows) if i % 4 == 0 or i + 1 == len(rows)]
    n = len(rows) // 3
    turned = [*rows[n:], *((t + period, x, v) for t, x, v in rows[: n + 1])]
    write_rows(path, "t,x,v", [(round(t + 7 * period, 5), round(x, 5), round(v, 5)) for t, x, v in turned])
    found = from_file("wall_oscillator", path, source={"signature": ["flight"]}, set={"omega": 2.35})
    assert found.orbit(0)["time"][0] == pytest.approx(impacts.orbit(0)["time"][0], abs=1e-9)
    assert found.orbit(0)["states"][0] == pytest.approx(impacts.orbit(0)["states"][0], abs=1e-9)


def test_an_orbit_that_meets_no_event_has_its_mode_named(tmp_path):
    # Linear between impacts: the amplitude is a / |1 - w^2 + i w c|.
    exact = 1.0 / abs(1 - 4 + 0.2j)
    times = np.linspace(0, math.pi, 13)
    write_rows(tmp_path / "free.csv", "t,x,v", [(t, -0.3 * math.cos(2 * t), 0.6 * math.sin(2 * t)) for t in times])
    source = {"mode": "free"}
    keys = {"set": {"wall": 0.5}, "monitors": {"amplitude": "amplitude(x)"}}
    found = from_file("wall_oscillator", tmp_path / "free.csv", source=source, **keys)
    assert found.points["monitors"][0, 0] == pytest.approx(exact, abs=1e-10)


def test_delayed_events_from_four_rows_a_segment(tmp_path):
    # x' = drive - x up to 1, reset to 0; tau later x falls by 0.1. Their times follow from the logarithm.
    drive, tau, kick = 1.5, 0.4, -0.1
    at_kick = drive * (1 - math.exp(-tau))
    period = tau + math.log((drive - at_kick - kick) / (drive - 1))
    first = [(t, drive * (1 - math.exp(-t))) for t in np.linspace(0, tau, 4)]
    low = at_kick + kick
    second = [(t, drive + (low - drive) * math.exp(tau - t)) for t in np.linspace(tau, period, 4)]
    write_rows(tmp_path / "neuron.csv", "t,x", [(round(t, 2), round(x, 2)) for t, x in [*first, *second]])
    found = from_file("spiking_neuron", tmp_path / "neuron.csv", source={"signature": ["pulse", "spike"]})
    assert found.points["period"][0] == pytest.approx(period, abs=1e-11)


@pytest.mark.parametrize(
    ("source", "step", "words"),
    [
        ({}, {}, "x.csv: nothing says which segments the rows run through"),
        ({"signature": ["flight", "flight"]}, {}, "do not run through the signature"),
        ({"signature": ["flown"]}, {}, "'flown' is not a segment of this model"),
        ({}, {"signature": ["flown"]}, "'flown' is not a segment of this model"),
        ({"mode": "fre"}, {}, "mode 'fre' is not defined; did you mean 'free'"),
        ({"mode": "free", "signature": ["flight"]}, {}, "leave 'signature' out"),
        ({"mode": "free"}, {}, "differs from the first by"),
        ({"step": "transient"}, {}, r"unknown key 'step' \(keys here: trajectory, signature, mode\)"),
        ({"trajectory": "y.csv"}, {}, "y.csv: cannot be read: No such file"),
        ({"trajectory": "."}, {}, "is not a plain file"),
        ({"trajectory": "bad.csv"}, {}, r"bad.csv:3:3: expected a finite number in column 'x', found 'one'"),
        ({"signature": []}, {}, "at least 1 item"),
    ],
)
def test_what_is_wrong_is_told_before_a_run(source, step, words, impacts, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.csv").write_text("t,x,v\n0,1,1\n1,one,1\n2,1,1\n3,1,1\n")
    write_rough(tmp_path / "x.csv", impacts, 0, columns=())
    orbit = {"from": {"trajectory": "x.csv", **source}, **step}
    whole = {"model": "wall_oscillator", "set": {"omega": 2.35}, "steps": [{"name": "orbit", "orbit": orbit}]}
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(whole, sort_keys=False))
    with pytest.raises(RunError, match=words) as caught:
        plan("run.yaml")
    assert all(problem.line > 1 and problem.column > 1 for problem in caught.value.problems)


def test_the_steps_signature_is_what_rows_are_cut_into(impacts, tmp_path):
    write_rough(tmp_path / "x.csv", impacts, 0, columns=())
    found = from_file("wall_oscillator", tmp_path / "x.csv", step={"signature": ["flight"]}, set={"omega": 2.35})
    assert found.orbit(0)["signature"].tobytes() == b"flight"


def test_a_file_that_has_changed_is_other_settings(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_sine(tmp_path / "sine.csv")
    whole = {"model": "wright", "steps": [{"name": "orbit", "orbit": {"from": {"trajectory": "sine.csv"}}}]}
    execute(plan(whole), tmp_path / "a.h5")
    execute(plan(whole), tmp_path / "a.h5", resume=True)
    write_sine(tmp_path / "sine.csv", n=24)
    with pytest.raises(ResultsError, match="was computed with other settings"):
        execute(plan(whole), tmp_path / "a.h5", resume=True)
    assert read_results(tmp_path / "a.h5").names == ("orbit",)


def test_the_file_is_not_written_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_sine(tmp_path / "sine.csv")
    whole = {"model": "wright", "steps": [{"name": "orbit", "orbit": {"from": {"trajectory": "sine.csv"}}}]}
    with pytest.raises(ResultsError, match=r"sine.csv is the file 'sine.csv' of step 'orbit' of this run"):
        execute(plan(whole), tmp_path / "sine.csv", overwrite=True)
