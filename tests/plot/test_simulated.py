"""Pictures of simulations show the numbers in the file: returns over a parameter, basins, trajectories."""

import numpy as np
import pytest

from pddecont.errors import ResultsError
from pddecont.plot.basin import basin_colours, draw_basin
from pddecont.plot.brute_force import classes, draw_branches, draw_returns
from pddecont.plot.choice import View, choose
from pddecont.plot.figure import draw, picture
from pddecont.plot.style import COLOURS, marker, palette
from pddecont.results.attractors import label_map
from tests.runs import run, run_model

RUN = """
model: ../models/impact_oscillator.yaml
effects: {off: [feedback]}
set: {beta: 40}
mesh: {degree: 8, tol: 1.0e-9}
steps:
  - {name: t, simulate: {t_end: 200*2*pi/omega, record: {signals: {wall: beta*(x - e)}}, at: {100: {a: 0.95}, 200: {a: 0.9}}}}
  - {name: o, orbit: {from: t, stability: true}}
  - {name: branch, continue: {from: o, free: [beta], range: {beta: [30, 45]}, stability: true, events_along: {P: beta - 37}}}
  - {name: diagram, sweep: {over: {beta: [30, 45, 4]}, initial: [{x: 0}, {x: -0.26, v: 1.74}], transient: 300*2*pi/omega, lyapunov: true}}
  - {name: plane, sweep: {over: {beta: [30, 45, 3], a: [0.9, 0.92, 2]}, transient: 150*2*pi/omega}}
  - {name: map, basin: {over: {x: [-2, 1.2, 10], v: [-2, 2, 9]}, transient: 300*2*pi/omega}}
  - {name: other, set: {beta: 90}, basin: {over: {x: [-2, 1.2, 10], v: [-2, 2, 9]}, transient: 300*2*pi/omega}}
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return run(RUN, tmp_path_factory.mktemp("simulated") / "s.h5")


@pytest.fixture
def axes():
    from matplotlib.figure import Figure

    return Figure().subplots()


def test_every_return_is_a_dot_in_its_classes_colour(results, axes):
    step = results.steps["diagram"]
    handles = draw_returns(axes, [step], "beta", "x")
    dots = np.concatenate([line.get_xydata() for line in axes.lines])
    recorded = np.concatenate([np.stack([np.full(2, step.points["parameters"][i, 4]), step.orbit(i)["returns"][:, 0]], axis=1)
                               for i in range(len(step))])  # fmt: skip
    assert {tuple(d) for d in dots} == {tuple(d) for d in recorded}
    assert [h.get_label() for h in handles] == list(classes([step])) == ["period 2, 1 NC, 1 C", "period 2, 2 NC, 2 C"]


def test_branches_lie_under_the_dots_they_explain(results, axes):
    step, branch = results.steps["diagram"], results.steps["branch"]
    draw_branches(axes, [branch], step, "beta", "x")
    lines = [line.get_xydata() for line in axes.lines]
    assert lines
    one = [i for i in range(len(step)) if step.points["n_segments"][i, 0] == 1]
    for i in one:
        beta = step.points["parameters"][i, 4]
        for x in step.orbit(i)["returns"][:, 0]:
            gap = min(np.min(np.abs(line[:, 1] - x)[np.abs(line[:, 0] - beta) < 2.0], initial=np.inf) for line in lines)
            assert gap < 0.03


def test_special_points_of_branches_are_marked_at_every_return(results, axes):
    step, branch = results.steps["diagram"], results.steps["branch"]
    tags, handles = draw_branches(axes, [branch], step, "beta", "x")
    assert [tag.text for tag in tags] == ["UF1"]
    (marks,) = (line.get_xydata() for line in axes.lines if line.get_marker() == marker("UF"))
    assert marks[:, 0] == pytest.approx([37.0, 37.0], abs=1e-9)
    assert (tags[0].x, tags[0].y) == pytest.approx(tuple(marks[0]))
    assert [h.get_label() for h in handles] == ["followed: orbits"]


def test_a_basin_shows_each_cell_in_its_attractors_colour(results, axes):
    both = [results.steps["map"], results.steps["other"]]
    colours = basin_colours(both)
    assert len(colours) == 2
    handles = draw_basin(axes, both[0], colours)
    assert np.array_equal(np.asarray(axes.collections[0].get_array()).reshape(9, 10), label_map(both[0]))
    assert sum(float(h.get_label().split(", ")[-1].removesuffix(" %")) for h in handles) == pytest.approx(100.0, abs=0.11)


MANY = """
name: m
states: [x, y]
parameters: {w: 1}
forcing: {period: w}
modes: {m: {x': "-sin(2*pi*x)", y': -y}, growing: {x': x, y': -y}, bursting: {x': x**3, y': -y}}
events: {low: x - 8.8, high: x - 10.8}
resets: {none: {}}
segments:
  grow: {mode: m, event: low, direction: rising, reset: none, to: growing}
  burst: {mode: m, event: high, direction: rising, reset: none, to: bursting}
run:
  steps:
    - {name: wells, basin: {over: {x: [0.12, 11.92, 60], y: [-1, 1, 3]}, transient: 60}}
"""


def test_a_basin_with_many_attractors_can_be_read(axes, tmp_path):
    """x settles at 0, 1, .. 12, more attractors than the palette has colours, but for some starts that leave for two reasons."""
    step = run_model(MANY, tmp_path / "m.h5").step("wells")
    colours = basin_colours([step])
    attractors = [colour for (name, _), colour in colours.items() if name != "none"]
    assert len(set(attractors)) == len(attractors) == 13
    *named, astray = [h.get_label() for h in draw_basin(axes, step, colours)]
    assert sorted(name.partition(":")[0] for name in named) == sorted(f"A{k + 1}" for k in range(13))
    assert " ".join(astray.split()) == ("no attractor recognised, 6.7 % the motion has not settled in the time of the transient "
                                        "no step is small enough")  # fmt: skip


def test_colours_beyond_the_palette_are_like_none_of_it():
    from matplotlib.colors import to_rgb

    for n in (9, 13, 20, 30):
        colours = np.array([to_rgb(c) for c in palette(n)])
        assert tuple(palette(n)[: len(COLOURS)]) == COLOURS
        gaps = np.linalg.norm(colours[:, None] - colours, axis=-1) + 9 * np.eye(n)
        assert gaps.min() > 0.05


def test_what_a_file_shows_by_itself_and_when_asked(results, tmp_path):
    kind, steps = choose(results, View())
    # The last sweep is over two parameters; a diagram of brute force stands over the branches in its parameter.
    assert (kind, [s.name for s in steps]) == ("sweep", ["plane"])
    assert choose(results, View("diagram"))[0] == "diagram"
    kind, steps = choose(results, View("sweep", ("diagram",)))
    assert (kind, [s.name for s in steps]) == ("sweep", ["diagram"])
    assert [s.name for s in choose(results, View("sweep", ("branch", "diagram")))[1]] == ["branch", "diagram"]
    assert [s.name for s in choose(results, View("basin"))[1]] == ["map", "other"]
    with pytest.raises(ResultsError, match="needs a sweep step"):
        choose(results, View("sweep", ("branch",)))
    views = [View("sweep", ("branch", "diagram")), View("sweep", ("plane",)), View("basin"), View("basin", ("map",)), View("trajectory"),
             View("trajectory", y="wall"), View("sweep", ("diagram",), y="v")]  # fmt: skip
    for number, view in enumerate(views):
        draw(results, view, tmp_path / f"{number}.png")
        assert (tmp_path / f"{number}.png").stat().st_size > 5000
    assert len(picture(results, View("trajectory")).axes) == 3
    # Lyapunov exponents have a panel of their own under the diagram.
    assert len(picture(results, View("sweep", ("diagram",))).axes) == 2
    with pytest.raises(ResultsError, match="did you mean 'wall'"):
        draw(results, View("trajectory", y="wal"), tmp_path / "a.png")


def test_a_signal_follows_the_parameters_of_its_time(results):
    """beta (x - e) beside x itself, and a trajectory whose forcing changes in between."""
    step = results.steps["t"]
    rows = step.orbit(0)
    assert rows["signals"][:, 0] == pytest.approx(40 * (rows["states"][:, 0] - 1.26), abs=1e-12)
    assert step.meta["changes"] == [100.0, 200.0]
