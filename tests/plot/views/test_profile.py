"""A state over one period, with its delayed values beside it."""

import numpy as np
import pytest

from tests.plot.drawn import lines
from tests.runs import run

PUSHED = {
    "name": "pushed",
    "states": ["x", "v"],
    "parameters": {"c": 0.3, "K": 0.2, "tau": 1.5},
    "forcing": {"period": "2*pi"},
    "modes": {"only": {"x'": "v", "v'": "cos(t) - c*v - 2*x + K*v(t - tau)"}},
    "run": {
        "steps": [
            {"name": "transient", "simulate": {"t_end": "60*pi"}},
            {"name": "orbit", "orbit": {"from": "transient"}},
        ]
    },
}


def test_delayed_values_are_the_state_as_much_later(tmp_path, show):
    results = run(PUSHED, tmp_path / "a.h5")
    [axes] = show(results, "profile", ("orbit",), y="v").axes
    [own], [delayed] = lines(axes, "-"), lines(axes, "--")
    earlier = np.interp((delayed[:, 0] - 1.5) % (2 * np.pi), own[:, 0], own[:, 1])
    assert delayed[:, 1] == pytest.approx(earlier, abs=1e-4 * np.ptp(own[:, 1]))
    [axes] = show(results, "profile", ("orbit",), y="x").axes
    assert lines(axes, "--") == []


def test_all_states_are_shown_by_name_and_events_as_lines(every, show):
    first, _ = show(every, "profile", ("in_gain",)).axes
    assert [text.get_text() for text in first.get_legend().get_texts()] == ["$x$", "$v$"]
    assert first.get_title() == "LP1  $K$ = 0.3"
    # Two states in two segments, and the event between these.
    assert len(lines(first, "-")) == 2 * 2 + 1
    assert first.get_xlim()[0] < 0 < 7 < first.get_xlim()[1]
