"""What accuracy costs: errors against closed forms, explicit and eliminated chains, resuming, tables and pictures."""

import numpy as np
import pytest

from pddecont.errors import RunError
from pddecont.results import read_results
from pddecont.steps.execution import precision as precision_step
from pddecont.tables import describe_endings
from pddecont.tables.precision import (
    describe_cheapest,
    find_cheapest,
    find_envelope,
    find_rows,
    fit_slope,
    list_settings,
    measure_distances,
    read_reference_error,
)
from tests.cli.test_cli import call
from tests.runs import change, run

# x' = a x - sgn x(t - tau) (shared validation table): period and amplitude in closed form.
RELAY = {
    "model": "relay",
    "set": {"a": 0.5},
    "steps": [
        {"name": "transient", "simulate": {"t_end": 60}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {
            "name": "cost",
            "precision": {
                "from": "orbit",
                "quantities": {"T": "period", "size": "amplitude(x)"},
                "reference": {"T": "2*(tau - log(2 - exp(a*tau))/a)", "size": "(exp(a*tau) - 1)/a"},
                "methods": [
                    {"method": "direct"},
                    {"method": "chain", "order": 2, "n": [10, 20, 40]},
                    {"method": "chain", "order": 2, "n": [10, 20, 40], "states": "explicit"},
                ],
                "degrees": [3, 6],
                "intervals": [8, 32],
                "repeats": 1,
            },
        },
    ],
}


@pytest.fixture(scope="module")
def relay(tmp_path_factory):
    return run(RELAY, tmp_path_factory.mktemp("cost") / "r.h5").step("cost")


def test_errors_are_those_from_the_closed_form(relay):
    T, size = 6.1847010803, 1.2974425414
    for row in list_settings(relay)[1:]:
        assert row["T_error"] == pytest.approx(abs(row["T"] - T) / T, abs=2e-11)
        assert row["size_error"] == pytest.approx(abs(row["size"] - size) / size, abs=1e-10)
        assert row["error"] == max(row["T_error"], row["size_error"])
    assert read_reference_error(relay) < 1e-12
    direct = [r["error"] for r in list_settings(relay) if r["method"] == "direct"]
    # Two exponential arcs a period: degree 6 resolves them, degree 3 by order 2 m = 6 at the intervals' ends.
    assert direct[3] < 1e-12
    assert 1e-12 < direct[1] < direct[0] < 1e-3
    assert "closed forms" in describe_endings(relay)[0]


def test_explicit_states_give_the_eliminated_chain(relay):
    p = relay.points
    eliminated, explicit = find_rows(relay, "chain of order 2"), find_rows(relay, "chain of order 2, explicit states")
    assert len(eliminated) == len(explicit) == 12
    assert p["values"][explicit] == pytest.approx(p["values"][eliminated], rel=1e-10)
    # One delayed quantity, n stages of two states.
    base = p["n_unknowns"][eliminated] - 2
    assert np.array_equal(p["n_unknowns"][explicit] - 2, base * (1 + 2 * p["n"][explicit]))


def test_costs_are_measured(relay):
    p = relay.points
    assert np.all(p["wall_low"] <= p["wall"]) and np.all(p["wall"] <= p["wall_high"])
    assert np.all(p["cpu"] > 0) and np.all(p["memory"] > 1000) and np.all(p["n_iterations"][1:] >= 2)
    many, few = (p["memory"][find_rows(relay, name)].max() for name in ("chain of order 2, explicit states", "direct"))
    assert many > few


def test_the_cheapest_setting_for_a_level(relay):
    for level in (1e-2, 1e-6, 1e-9):
        i = find_cheapest(relay, level)
        reaching = relay.points["cpu"][1:][relay.points["error"][1:] <= level]
        assert relay.points["error"][i] <= level and relay.points["cpu"][i] == reaching.min()
    assert find_cheapest(relay, 1e-30) is None
    assert [line[:5] for line in describe_cheapest(relay)] == ["1e-03", "1e-06", "1e-09"]


def test_slopes_and_envelopes():
    x = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
    assert fit_slope(x, 3 * x**-2.0, 0.0) == pytest.approx(-2)
    assert fit_slope(x, np.maximum(x**-2.0, 0.02), 0.02) == pytest.approx(-2)  # what lies at the floor does not count
    assert np.isnan(fit_slope(x[:2], x[:2], 0.0))
    assert find_envelope(np.array([3.0, 1.0, 2.0]), np.array([0.1, 0.5, 0.7])).tolist() == [1, 0]


IMPACT = {
    "model": "impact_oscillator",
    "steps": [
        {"name": "transient", "simulate": {"t_end": "300*2*pi/omega"}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {
            "name": "cost",
            "precision": {
                "from": "orbit",
                "quantities": {"v": "at(NC, v)"},
                "methods": [{"method": "direct"}, {"method": "chain", "order": 2, "n": [20, 40, 80]}],
                "degrees": 8,
                "tolerances": [0.0001, 1e-07],
                "repeats": 1,
            },
        },
        {"name": "short", "simulate": {"t_end": "10*2*pi/omega", "initial": {"x": 0.5}}},
        {
            "name": "runs",
            "precision": {
                "from": "short",
                "quantities": {"x": "x", "u": "v(t - tau_d)"},
                "tolerances": [1e-05, 1e-08, 1e-11],
                "repeats": 1,
            },
        },
    ],
}


@pytest.fixture(scope="module")
def impact(tmp_path_factory):
    return run(IMPACT, tmp_path_factory.mktemp("cost") / "i.h5")


def test_the_impact_velocity_and_the_distance_of_eq_4_1(impact):
    step = impact.step("cost")
    # 0.734426370925 is an independent prototype's.
    assert step.points["values"][0, 0] == pytest.approx(0.734426370925, abs=1e-11)
    n, distance, order = measure_distances(step)["chain of order 2"]
    assert n.tolist() == [20, 40, 80]
    assert order == pytest.approx(2.0, abs=0.1)
    row = int(find_rows(step, "chain of order 2")[-1])
    ends = np.array(step.meta["ends"])
    assert ends[:, 0] == pytest.approx([1.26, 1.26], abs=1e-12)
    # On the surface x = e only the velocities differ; the first of them is the quantity.
    assert distance[-1] > abs(step.points["values"][row, 0] - ends[0, 1])


def test_simulations_are_compared_by_tolerance_and_integrator(impact):
    step = impact.step("runs")
    assert read_reference_error(step) < 1e-10
    for name in ("explicit", "stiff"):
        errors = step.points["error"][find_rows(step, name)]
        assert len(errors) == 3 and errors[2] < 1e-2 * errors[1] < 1e-4 * errors[0]
    assert np.all(step.points["n_steps"] > 0)


def test_it_is_resumed_where_it_broke_off(tmp_path, relay, monkeypatch):
    path, whole, calls = tmp_path / "r.h5", precision_step.measure_cost, []

    def breaking(compute, repeats):
        calls.append(compute)
        if len(calls) == 8:
            raise KeyboardInterrupt
        return whole(compute, repeats)

    with monkeypatch.context() as patch:
        patch.setattr(precision_step, "measure_cost", breaking)
        with pytest.raises(KeyboardInterrupt):
            run(RELAY, path)
    kept = read_results(path).step("cost")
    assert len(kept) == 7
    done = run(RELAY, path, resume=True).step("cost")
    assert np.array_equal(done.points["values"], relay.points["values"])
    assert np.array_equal(done.points["wall"][:7], kept.points["wall"])


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("integrators", ["stiff"], "does not go with orbits"),
        ("reference", {"t": "2*pi"}, "is not among the quantities"),
        ("quantities.T", "x", "varies along the orbit"),
        ("methods.1.order", 99, "less than or equal to 20"),
        ("methods.0", {"method": "direct", "n": 3}, "does not go with method 'direct'"),
        ("methods.0", {"method": "direct", "states": "explicit"}, "does not go with method 'direct'"),
        ("from", "cost", "is not above this one"),
        ("tolerances", [1.0e-3], "exclude each other"),
    ],
)
def test_what_is_wrong_is_said(path, value, message, tmp_path):
    with pytest.raises(RunError, match=message):
        run(change(RELAY, f"steps.2.precision.{path}", value), tmp_path / "r.h5")


def test_commands_show_it(impact, tmp_path):
    path = str(impact.path)
    code, out, _ = call("info", path)
    assert code == 0 and "1e-06: direct" in out
    code, out, _ = call("export", path, "--step", "cost", "--table", "precision")
    assert code == 0 and out.splitlines()[0].startswith("index,method,setting,degree")
    assert len(out.splitlines()) == 10
    for view, step in (("precision", "cost"), ("precision", "runs"), ("distance", "cost")):
        picture = tmp_path / f"{view}_{step}.png"
        assert call("plot", path, "--view", view, "--step", step, "-o", str(picture))[0] == 0
        assert picture.stat().st_size > 10_000
