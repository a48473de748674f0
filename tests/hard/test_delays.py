"""Delays of 1e-6 and of 100 periods."""

import math

import numpy as np
import pytest

from tests.problems import chain_transfer, grazing_amplitude
from tests.runs import parameter, run

FREE = {
    "model": "impact_oscillator",
    "effects": {"off": ["impact"]},
    "mesh": {"degree": 9, "tol": 1e-11},
    "monitors": {"top": "max(x)"},
}
IMPACT = {"model": "impact_oscillator", "mesh": {"degree": 9, "tol": 1e-11}, "monitors": {"speed": "at(NC, v)"}}
TURN = 2 * math.pi / 0.8


def settle(n_turns, changes):
    """Return a simulation that runs for so many turns."""
    return {"name": "t", "set": changes, "simulate": {"t_end": n_turns * TURN}}


@pytest.mark.parametrize("tau", [1e-6, 1e-3, 100 * TURN + 3.8, 100.5 * TURN])
def test_the_free_orbit_in_closed_form(tmp_path, tau, record):
    steps = [settle(60, {"tau_d": 3.8}), {"name": "o", "set": {"tau_d": tau}, "orbit": {"from": "t"}}]
    top = run({**FREE, "steps": steps}, tmp_path / "a.h5").step("o").points["monitors"][0, 0]
    record(
        f"amplitude without impacts, delay {tau:.7g}",
        "closed form",
        abs(top - grazing_amplitude(0.12, np.exp(-0.8j * tau))),
        1e-9,
    )


@pytest.mark.parametrize(("tau", "chain", "n"), [(1e-6, 2, 15), (100.5 * TURN, 2, 1000)])
def test_the_same_through_a_chain(tmp_path, tau, chain, n, record):
    through = {"method": "chain", "order": chain, "n": n}
    steps = [settle(60, {"tau_d": 3.8}), {"name": "o", "set": {"tau_d": tau}, "delay": through, "orbit": {"from": "t"}}]
    step = run({**FREE, "mesh": {"degree": 9, "intervals": 16}, "steps": steps}, tmp_path / "a.h5").step("o")
    expected = grazing_amplitude(0.12, chain_transfer(0.8, tau, chain, n))
    top = step.points["monitors"][0, 0]
    record(f"the same through a chain of {n}, delay {tau:.7g}", "closed form of the chain", abs(top - expected), 1e-9)


def test_a_hundred_periods_later_the_orbit_is_the_same(tmp_path, record):
    """A delay longer by whole periods reads the same values: the impacting orbit cannot tell."""

    def with_branch(tau, ends):
        branch = {"from": "far", "free": ["tau_d"], "range": {"tau_d": ends}}
        steps = [
            settle(60, {}),
            {"name": "near", "orbit": {"from": "t"}},
            {"name": "far", "set": {"tau_d": tau}, "orbit": {"from": "near"}},
            {"name": "branch", "continue": branch},
        ]
        return {**IMPACT, "steps": steps}

    results = run(with_branch(3.8 + 200 * TURN, [1574.4, 1574.8]), tmp_path / "a.h5")
    near, far = (results.step(name).points["monitors"][0, 0] for name in ("near", "far"))
    record("impact speed, delay longer by 100 periods", "the orbit at the short delay", abs(far - near), 1e-9)
    again = run(with_branch(3.8, [1574.4 - 200 * TURN, 1574.8 - 200 * TURN]), tmp_path / "b.h5")
    ends = [
        r.step("branch").points["monitors"][r.step("branch").row(f"EP{k}"), 0] for r in (results, again) for k in (1, 2)
    ]
    record(
        "the ends of a branch in that delay",
        "the branch at the short delay",
        max(abs(ends[0] - ends[2]), abs(ends[1] - ends[3])),
        1e-9,
    )


def test_the_shortest_delay_is_an_added_mass(tmp_path, record):
    """v(t - tau) - v = -tau v' + O(tau^2): to first order K tau joins the mass, and the orbit is that of an equation
    without delay.
    """
    K, tau = 0.12, 1e-6
    from_rest = settle(250, {"K": 0})
    steps = [
        from_rest,
        {"name": "o", "set": {"K": 0}, "orbit": {"from": "t"}},
        {"name": "p", "set": {"tau_d": tau, "K": K}, "orbit": {"from": "o"}},
    ]
    delayed = run({**IMPACT, "steps": steps}, tmp_path / "a.h5")
    m = 1 + K * tau
    # x'' (1 + K tau) + 2 zeta x' + x: the same equation with another clock, omega and damping scaled by the square root
    # of the mass.
    root = math.sqrt(m)
    changes = {"omega": 0.8 * root, "a": 0.9 / m, "zeta": 0.01 / root, "K": 0}
    steps = [from_rest, {"name": "o", "set": changes, "orbit": {"from": "t"}}]
    plain = run({**IMPACT, "steps": steps}, tmp_path / "b.h5")
    speeds = delayed.step("p").points["monitors"][0, 0], plain.step("o").points["monitors"][0, 0] / root
    without = delayed.step("o").points["monitors"][0, 0]
    assert abs(speeds[0] - without) > 1e-9
    record("impact speed, delay 1e-6", "K tau as a mass, to O(tau^2)", abs(speeds[0] - speeds[1]), 1e-10)


def test_down_to_the_shortest_delay(tmp_path, record):
    branch = {"from": "o", "free": ["tau_d"], "range": {"tau_d": [1e-6, 0.5]}, "direction": "down"}
    mapping = {
        **IMPACT,
        "mesh": {"degree": 9, "tol": 1e-9},
        "set": {"K": 0.01, "tau_d": 0.5},
        "steps": [
            settle(120, {}),
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": branch},
            {"name": "zero", "set": {"tau_d": 0}, "orbit": {"from": {"step": "c", "point": "EP1"}}},
        ],
    }
    results = run(mapping, tmp_path / "a.h5")
    branch = results.step("c")
    assert parameter(branch, "tau_d", "EP1") == pytest.approx(1e-6, abs=1e-15)
    gap = branch.points["monitors"][branch.row("EP1"), 0] - results.step("zero").points["monitors"][0, 0]
    record("branch from delay 0.5 down to 1e-6", "the orbit without delay, to O(K tau)", abs(gap), 1e-7)
