"""The Python interface against the command line's own tables and against closed forms."""

import csv
import doctest
import io
import re
import subprocess
import sys
import warnings

import numpy as np
import pytest

import pddecont
import pddecont.api
from pddecont.errors import ConvergenceError, ModelError, PddecontError, ResultsError, RunError
from pddecont.runfile import RunBlock
from pddecont.steps import list_step_kinds
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.runs import to_yaml

RELAY = (ROOT / "models" / "relay.yaml").read_text()
STEPS = [
    {"name": "transient", "simulate": {"t_end": 60}},
    {"name": "orbit", "orbit": {"from": "transient"}},
    {"name": "in_growth", "continue": {"from": "orbit", "free": ["a"], "range": {"a": [np.float64(0.3), 0.6]}}},
]


@pytest.fixture(scope="module")
def relay(tmp_path_factory):
    """Return the relay's run, its steps and monitors given in Python, kept in a file."""
    path = tmp_path_factory.mktemp("relay") / "relay.h5"
    units = RELAY.replace("parameters:", "units: {x: mm, t: s, a: 1/s}\nparameters:", 1)
    return pddecont.run(units, steps=STEPS, output=path, monitors={"top": "max(x)", "share": "time_in(pull)/period"})


def test_the_relays_amplitude_is_the_closed_form(relay):
    # x' = a x - 1 for the time tau after x = 0: x = -(exp(a tau) - 1)/a.
    data = relay["in_growth"].arrays()
    assert data["a"][[0, -1]] == pytest.approx([0.3, 0.6])
    assert data["top"] == pytest.approx(np.expm1(data["a"]) / data["a"], rel=1e-8)
    assert data["share"] == pytest.approx(0.5)


def test_arrays_are_the_exported_table(relay):
    rows = list(csv.DictReader(io.StringIO(call("export", relay.path)[1])))
    data = relay["in_growth"].arrays()
    assert list(rows[0]) == list(data)
    for name in ("a", "period", "top", "error_estimate"):
        assert [float(row[name]) for row in rows] == data[name].tolist()
    assert [row["label"] for row in rows] == data["label"].tolist()
    assert np.all(np.isnan(data["stable"]))
    assert data["admissible"].dtype == bool


def test_a_branch_is_a_data_set_with_units_and_coordinates(relay):
    ds = relay.branch("in_growth")
    assert ds.sizes["point"] == len(relay["in_growth"])
    assert set(ds.coords) == {"a", "label"}
    assert {name: ds[name].attrs.get("units") for name in ("a", "top", "period", "tau")} == {
        "a": "1/s",
        "top": "mm",
        "period": "s",
        "tau": None,
    }
    at = ds.where(ds.label == "EP2", drop=True)
    assert at.a.item() == pytest.approx(0.6)
    assert "multiplier" not in ds
    assert ds.attrs["kind"] == "continue"


def test_multipliers_are_in_the_data_set():
    steps = [
        {"name": "transient", "simulate": {"t_end": 150}},
        {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
    ]
    found = pddecont.run("wright", steps=steps)
    ds = found.branch("orbit")
    z = ds["multiplier"].values[0]
    assert np.iscomplexobj(z)
    assert z[0] == pytest.approx(1.0, abs=1e-6)  # an autonomous orbit has the multiplier 1
    assert bool(ds["stable"].item())


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda r: r["nothing"], r"has no step 'nothing' \(steps: transient, orbit, in_growth\)"),
        (lambda r: r[0], r"has no step '0' \(steps: "),
        (lambda r: r.branch("in_growht"), "has no step 'in_growht'; did you mean 'in_growth'"),
        (lambda r: r["in_growth"].table("foo"), r"has no table 'foo' \(it has: points, special, orbit, multipliers\)$"),
        (lambda r: r["in_growth"].table("point"), r"has no table 'point'; did you mean 'points'\? \(it has: "),
        (lambda r: r["transient"].table("points"), r"has no table 'points' \(it has: trajectory, events\)$"),
        (lambda r: r["in_growth"].table("orbit", "LP3"), r"has no point 'LP3' \(labels: EP1, EP2\)"),
        (lambda r: r["in_growth"].orbit("LP3"), r"has no point 'LP3'"),
        (lambda r: r["in_growth"].orbit(1000), r"points, no index 1000"),
        (lambda r: r["in_growth"].orbit(-1), r"points, no index -1"),
        (lambda r: r["transient"].orbit(), "is a simulate step and holds no orbits"),
        (lambda r: r.plot(view="profile", indices=[-1]), "there is no index -1"),
    ],
)
def test_what_is_not_there_is_a_results_error(relay, ask, message):
    with pytest.raises(ResultsError, match=message):
        ask(relay)


def test_a_trajectory_is_a_data_set_over_time(relay):
    ds = relay["transient"].dataset()
    assert ds.t.values[[0, -1]] == pytest.approx([0, 60])
    assert set(np.unique(ds["mode"])) == {"pull", "push"}
    assert ds.x.attrs == {"units": "mm", "long_name": "state x"}


def test_an_orbit_by_label_and_by_index(relay):
    step = relay["in_growth"]
    orbit = step.orbit("EP2")
    assert np.max(orbit["x"]) == pytest.approx(step.arrays()["top"][-1], rel=1e-6)
    assert orbit["t"][-1] - orbit["t"][0] == pytest.approx(step.arrays()["period"][-1])
    same = step.orbit(step.step.row("EP2"))
    assert np.array_equal(orbit["x"], same["x"])
    with pytest.raises(ResultsError, match="has no point 'GR1'"):
        step.orbit("GR1")
    with pytest.raises(ResultsError, match="holds no orbits"):
        relay["transient"].orbit()


def test_results_are_a_mapping_that_says_what_it_holds(relay):
    assert list(relay) == ["transient", "orbit", "in_growth"]
    assert len(relay) == 3
    assert "orbit" in relay and "orbits" not in relay
    assert "continue step 'in_growth'" in repr(relay)
    assert relay["in_growth"].labels == ("EP1", "EP2")
    with pytest.raises(ResultsError, match="did you mean 'orbit'"):
        relay["orbits"]
    assert relay.summary()["steps"][2]["n_points"] == len(relay["in_growth"])
    assert [row["label"] for row in relay["in_growth"].table("special")] == ["EP1", "EP2"]


def test_pictures_are_figures_or_files(relay, tmp_path):
    figure = relay.plot(steps=["in_growth"], y="period")
    assert figure.axes[0].get_xlabel() == "$a$ (1/s)"
    assert figure.axes[0].get_ylabel() == "period (s)"
    assert relay.plot(tmp_path / "p.svg") is None
    assert (tmp_path / "p.svg").read_text().startswith("<?xml")


def test_a_file_and_the_command_line_give_the_same_numbers(relay, in_folder):
    text = (ROOT / "models" / "relay.yaml").read_text().replace("[0, 0.65]", "[0.3, 0.6]")
    (in_folder / "relay.yaml").write_text(text)
    assert call("run", "relay.yaml", "-q")[0] == 0
    a, b = pddecont.load("relay.h5")["in_growth"].arrays(), relay["in_growth"].arrays()
    assert np.array_equal(a["period"], b["period"])


def test_parameters_and_effects_as_on_the_command_line():
    found = pddecont.run("relay", steps=STEPS[:2], set={"a": 0.25, "tau": "4*a"}, monitors={"top": "max(x)"})
    assert found["orbit"].arrays()["top"] == pytest.approx(np.expm1(0.25) / 0.25)
    found = pddecont.run("relay", without=["growth"], steps=STEPS[:2])
    assert found["orbit"].arrays()["amplitude"] == pytest.approx(1.0)  # slopes of one for the time tau


def test_a_model_may_be_a_mapping_and_nothing_is_kept_without_output(in_folder):
    model = {
        "name": "decay",
        "states": ["x"],
        "parameters": {"k": 2.0},
        "modes": {"only": {"x'": "-k*x"}},
        "initial": {"x": 1},
    }
    found = pddecont.run(model, steps=[{"name": "fall", "simulate": {"t_end": 1, "rtol": 1e-10}}])
    assert found["fall"].arrays()["x"][-1] == pytest.approx(np.exp(-2.0), rel=1e-8)
    assert not found.path.exists()
    assert not list(in_folder.iterdir())


def test_a_run_file_keeps_its_model_when_its_keys_are_replaced(in_folder):
    (in_folder / "there").mkdir()
    (in_folder / "there" / "m.yaml").write_text(RELAY)
    (in_folder / "there" / "r.yaml").write_text(
        to_yaml({"model": "m.yaml", "steps": [{"name": "a", "simulate": {"t_end": 1}}]})
    )
    found = pddecont.run(in_folder / "there" / "r.yaml", steps=[{"name": "b", "simulate": {"t_end": 2}}])
    assert found["b"].arrays()["t"][-1] == 2.0


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (("no_such_model",), RunError, "does not exist"),
        (("states: [x\n",), RunError, "not valid YAML"),
        ((RELAY.replace("a*x - 1", "a*y - 1"),), ModelError, "<python>:7:.*'y'"),
        (({"name": "m", "states": ["x"]},), ModelError, "needs 'equations'"),
        (({"name": "m", "states": ["x"], "modes": {"m": {"x'": 0}}},), RunError, "says nothing of a run"),
        (({"name": object()},), RunError, "cannot be written in a run; expected text, a number"),
    ],
)
def test_errors_are_those_of_the_command_line(arguments, error, message):
    with pytest.raises(error, match=message):
        pddecont.run(*arguments)


@pytest.mark.parametrize(
    ("steps", "keys", "message"),
    [
        ([{"name": "a", "simulate": {"t_end": "3*zz"}}], {}, "<python>: run.steps[0].simulate.t_end: 'zz' is not"),
        ([{"name": "a", "simulate": {"t_end": 1}}, {"name": "b", "orbit": {"fro": "a"}}], {}, "run.steps[1].orbit.fro"),
        (STEPS[:1], {"monitors": {"q": "foo(x)"}}, "<python>: run.monitors.q: unknown function 'foo'"),
    ],
)
def test_what_is_wrong_in_a_mapping_is_named_by_its_keys(steps, keys, message):
    model = {"name": "m", "states": ["x"], "modes": {"only": {"x'": "-x"}}, "initial": {"x": 1}}
    with pytest.raises(RunError, match=re.escape(message)):
        pddecont.run(model, steps=steps, **keys)


def test_a_model_that_is_wrong_is_named_by_its_keys():
    with pytest.raises(ModelError, match=re.escape("<python>: modes.only.x': 'y' is not defined")):
        pddecont.run({"name": "m", "states": ["x"], "modes": {"only": {"x'": "-y"}}}, steps=STEPS[:1])


def test_wrong_steps_keys_and_parameters_are_told():
    with pytest.raises(RunError, match="did you mean 'simulate'"):
        pddecont.run("relay", steps=[{"name": "a", "simulat": {}}])
    with pytest.raises(RunError, match="unknown key 'monitor'; did you mean 'monitors'"):
        pddecont.run("relay", monitor={})
    with pytest.raises(RunError, match="'b' is not a parameter"):
        pddecont.run("relay", set={"b": 1})
    with pytest.raises(RunError, match="--only"):
        pddecont.run("relay", only="nothing")
    with pytest.raises(PddecontError, match="does not exist"):
        pddecont.load("nothing.h5")


def test_what_exists_is_not_overwritten_and_what_failed_is_kept(in_folder):
    (in_folder / "a.h5").write_text("mine")
    with pytest.raises(ResultsError, match="--overwrite"):
        pddecont.run("relay", output="a.h5")
    assert (in_folder / "a.h5").read_text() == "mine"
    steps = [{"name": "transient", "simulate": {"t_end": 60}}, {"name": "orbit", "orbit": {"from": "transient"}}]
    # The growth outruns the relay: the motion leaves for good and no orbit is found.
    with pytest.raises((ConvergenceError, PddecontError)):
        pddecont.run("relay", set={"a": 1.5}, steps=steps, output="b.h5")
    assert list(pddecont.load("b.h5"))[:1] in ([], ["transient"])


def test_warnings_are_warnings():
    text = RELAY.replace("{a: 0.5, tau: 1}", "{a: 0.5, tau: 1, idle: 3}")
    with pytest.warns(UserWarning, match="'idle' is not used"):
        pddecont.run(text, only="transient")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pddecont.run(RELAY, only="transient")


def test_without_xarray_there_are_arrays_and_advice(relay, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ResultsError, match=r"install 'pddecont\[xarray\]'"):
        relay.branch("in_growth")
    assert len(relay["in_growth"].arrays()["a"])


def test_importing_the_package_loads_nothing_heavy():
    heavy = ("numpy", "sympy", "h5py", "pddecont.api")
    code = f"import sys, pddecont; pddecont.__version__; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    assert {"run", "load", "RunResults"} <= set(dir(pddecont))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        pddecont.nothing  # noqa: B018


def test_what_only_shows_results_is_loaded_when_they_are_shown():
    shown = ("matplotlib", "jinja2", "plotly", "pandas", "xarray", "IPython", "pddecont.plot.registry")
    code = f"import sys; from pddecont.api import load, run; print([m for m in {shown} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_examples_in_docstrings_work():
    found = doctest.testmod(pddecont.api)
    assert found.attempted >= 4
    assert found.failed == 0


@pytest.mark.parametrize("text", re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(), re.S))
def test_the_pages_examples_run_as_written(text, in_folder):
    exec(compile(text, "python.md", "exec"), {})
    assert "impact.png" not in text or (in_folder / "impact.png").exists()


def test_a_diagram_is_explored_as_by_the_command_again_and_again(tmp_path):
    model = {"name": "p", "states": ["x"], "parameters": {"a": 1}, "modes": {"free": {"x'": "a*x - x**3"}}}
    for n in (1, 2):
        results = pddecont.explore(model, {"a": [-1, 2]}, starts=4, check=0, max_branches=n)
        assert results["explore"].kind == "explore"
        assert [name for name in results if name.startswith("branch")] == [f"branch_{k + 1}" for k in range(n)]


def test_an_orbit_is_confirmed_where_the_effect_with_the_delay_is_left_out():
    # Its past has no delayed values then; what is left is the forced impact oscillator.
    found = pddecont.run("impact_oscillator", without=["feedback"], until="orbit")
    row = found["orbit"].table()[0]
    assert row["verified"] is True
    assert row["K"] == 0.0


def test_types_of_keys_are_those_of_the_schema():
    run, explore = pddecont.api.RunKeys.__annotations__, pddecont.api.ExploreKeys.__annotations__
    assert set(run) == set(RunBlock.model_fields) - {"set", "steps"}
    own = set(list_step_kinds()["explore"].fields.model_fields)
    assert set(explore) == own - {"over", "max_branches"}
