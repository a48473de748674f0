"""The registry is the one place that knows views: one of somebody else's is drawn, listed and reported like others."""

import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

import pddecont.plot.views
from pddecont.plot import VIEWS, Drawing, View, register_view
from tests.cli.test_cli import call
from tests.plot.synthetic import gain


@pytest.fixture
def clock():
    """Register a view that is shown of steps of simulated orbits, and forget it in the end."""

    def draw_clock(steps, request):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(1, 1))
        figure.subplots().set_title(f"{steps[-1].name} {request.x}")
        return figure

    source = Drawing(draw_clock, can_show=lambda step: len(step) == 1)
    register_view(View("clock", "what o'clock it is", source, places={"orbit": 3, "continue": 6}))
    yield VIEWS["clock"]
    del VIEWS["clock"]


def test_every_view_has_a_file_of_its_own():
    folder = Path(pddecont.plot.views.__file__).parent
    assert {path.stem for path in folder.glob("*.py")} - {"__init__"} == set(VIEWS)
    assert all(isinstance(view.drawing, Drawing) for view in VIEWS.values())


def test_every_kind_of_step_has_one_default():
    places = Counter((kind, place) for view in VIEWS.values() for kind, place in view.places.items())
    assert set(places.values()) == {1}
    kinds = {"simulate", "orbit", "continue", "curve", "sweep", "basin", "precision", "explore"}
    kinds |= {"equilibrium", "equilibria", "equilibrium_curve"}
    assert {kind for kind, place in places if place == 0} == kinds
    assert all(set(view.together) <= set(view.places) for view in VIEWS.values())


def test_names_and_descriptions_are_known_without_numpy():
    code = "import sys; from pddecont.plot import VIEWS; print(len(VIEWS), 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.split() == [str(len(VIEWS)), "False"]


def test_a_view_from_outside_is_drawn_listed_and_reported(made, clock, tmp_path):
    path = made(one=(gain()[:1], {"kind": "orbit"}), several=(gain()[:3], {})).path
    code, _, err = call("plot", path, "--view", "clock", "--step", "one", "-x", "v", "-o", tmp_path / "c.svg")
    assert code == 0, err
    assert ">one v<" in (tmp_path / "c.svg").read_text()
    assert call("plot", path, "--list")[1].splitlines() == [
        "one  orbit  orbit, profile, multipliers, clock",
        "several  continue  diagram, orbit, profile, multipliers, animate",
    ]
    assert "clock        what o'clock it is" in call("plot", "--help")[1]
    assert call("report", made(one=(gain()[:1], {"kind": "orbit"})).path, "-o", tmp_path / "r.html")[0] == 0
    assert 'alt="one: clock"' in (tmp_path / "r.html").read_text()


def test_a_view_that_is_not_registered_is_refused(every):
    code, _, err = call("plot", every.path, "--view", "clock")
    assert code == 2
    assert "'clock' is not one of 'diagram', 'plane'" in err
