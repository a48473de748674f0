"""Basins show the numbers in the file."""

import numpy as np
import pytest

from pddecont.plot.views.basin import NOWHERE, assign_attractor_colours, draw_basin
from pddecont.tables import read_label_map
from tests.runs import run

MANY = {
    "name": "m",
    "states": ["x", "y"],
    "parameters": {"w": 1},
    "forcing": {"period": "w"},
    "modes": {
        "m": {"x'": "-sin(2*pi*x)", "y'": "-y"},
        "growing": {"x'": "x", "y'": "-y"},
        "bursting": {"x'": "x**3", "y'": "-y"},
    },
    "events": {"low": "x - 8.8", "high": "x - 10.8"},
    "resets": {"none": {}},
    "segments": {
        "grow": {"mode": "m", "event": "low", "direction": "rising", "reset": "none", "to": "growing"},
        "burst": {"mode": "m", "event": "high", "direction": "rising", "reset": "none", "to": "bursting"},
    },
    "run": {
        "steps": [{"name": "wells", "basin": {"over": {"x": [0.12, 11.92, 60], "y": [-1, 1, 3]}, "transient": 60}}]
    },
}


def test_a_basin_shows_each_cell_in_its_attractors_colour(simulated, axes):
    both = [simulated.steps["map"], simulated.steps["other"]]
    colours = assign_attractor_colours(both)
    assert len(colours) == 2
    handles = draw_basin(axes, both[0], colours)
    assert np.array_equal(np.asarray(axes.collections[0].get_array()).reshape(5, 6), read_label_map(both[0]))
    assert sum(float(h.get_label().split(", ")[-1].removesuffix(" %")) for h in handles) == pytest.approx(
        100.0, abs=0.11
    )


def test_a_basin_with_many_attractors_can_be_read(axes, tmp_path):
    """x settles at 0, 1, .. 12, more than the palette has colours; some starts leave for two reasons."""
    step = run(MANY, tmp_path / "m.h5").step("wells")
    colours = assign_attractor_colours([step])
    attractors = [colour for (name, _), colour in colours.items() if name != "none"]
    assert len(set(attractors)) == len(attractors) == 13
    assert {colour for (name, _), colour in colours.items() if name == "none"} == {NOWHERE}
    *named, astray = [h.get_label() for h in draw_basin(axes, step, colours)]
    assert sorted(name.partition(":")[0] for name in named) == sorted(f"A{k + 1}" for k in range(13))
    assert " ".join(astray.split()) == (
        "no attractor recognised, 6.7 % the motion has not settled in the time of the transient no step is small enough"
    )
    *few, others, _ = [h.get_label() for h in draw_basin(axes, step, colours, 6)]
    assert (few, others) == (named[:5], "and 8 more")


def test_several_basins_have_a_panel_each_and_what_differs_above(simulated, show):
    figure = show(simulated, "basin")
    assert [axes.get_title() for axes in figure.axes] == [r"$\beta$ = 40", r"$\beta$ = 90"]
    assert all(axes.get_legend() for axes in figure.axes)
    [axes] = show(simulated, "basin", ("map",)).axes
    assert (axes.get_title(), axes.get_xlabel()) == ("", "$x$ at the start")
