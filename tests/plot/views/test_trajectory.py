"""Simulations over time."""

import numpy as np
import pytest

from pddecont.errors import ResultsError


def test_the_first_states_and_all_signals_have_a_panel(simulated, show):
    figure = show(simulated, "trajectory")
    assert [axes.get_ylabel() for axes in figure.axes] == ["$x$", "$v$", r"$\mathit{wall}$"]
    assert [axes.get_xlabel() for axes in figure.axes] == ["", "", "$t$"]
    rows = simulated.steps["t"].orbit(0)
    for axes, values in zip(figure.axes, (*rows["states"][:, :2].T, rows["signals"][:, 0]), strict=True):
        assert np.array_equal(axes.lines[0].get_xydata(), np.column_stack([rows["time"], values]))


def test_one_may_be_chosen(simulated, show):
    [axes] = show(simulated, "trajectory", y="wall").axes
    assert axes.get_ylabel() == r"$\mathit{wall}$"
    with pytest.raises(ResultsError, match="did you mean 'wall'"):
        show(simulated, "trajectory", y="wal")


def test_dashed_lines_stand_where_parameters_change(simulated, show):
    [axes] = show(simulated, "trajectory", y="x").axes
    start = simulated.steps["t"].orbit(0)["time"][0]
    assert simulated.steps["t"].meta["changes"] == [100.0, 200.0]
    changes = [t for t in (100.0, 200.0) if t >= start]
    assert [line.get_xdata()[0] for line in axes.lines if line.get_linestyle() == "--"] == changes


def test_a_signal_follows_the_parameters_of_its_time(simulated):
    """beta (x - e) beside x itself, and a trajectory whose forcing changes in between."""
    rows = simulated.steps["t"].orbit(0)
    assert rows["signals"][:, 0] == pytest.approx(40 * (rows["states"][:, 0] - 1.26), abs=1e-12)
