"""User functions: expressions over monitors whose zeros are located and followed."""

import numpy as np
import pytest

from pddecont.bifurcation import StartError, find_kind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.user_function import CODE, LABEL, UserFunction
from pddecont.collocation import MeshRule
from pddecont.orbit import PeriodicOrbitSystem, measure_orbit, parse_monitor
from pddecont.reasons import make_reason
from pddecont.results import read_results
from pddecont.steps import Silent
from pddecont.steps.execution import execute
from pddecont.tables import describe_endings, describe_reason
from tests.bifurcation.runs import FREE, follow, free_amplitude, settle
from tests.runs import labels, monitor, parameter, plan, run

LONG = "the_amplitude_of_the_free_orbit_at_which_the_wall_is_touched"
LEVELS = {LONG: "top - 0.25", "other": "c - 0.3"}


def run_of(name):
    """Return a run that finds where the amplitude is 1/4, by a user function of a name, and follows that curve."""
    levels = {name if key == LONG else key: value for key, value in LEVELS.items()}
    steps = [
        *settle(200),
        follow("c", "o", {"omega": [1.7, 2.7]}, direction="down", events_along=levels, stability=True),
        follow("uf", ("c", "UF1"), {"omega": [1.7, 2.7], "c": [0.01, 0.5]}, events_along=levels, stability=True),
    ]
    return {**FREE, "run": {"mesh": {"degree": 8, "tol": 1e-10}, "monitors": {"top": "max(x)"}, "steps": steps}}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run(run_of(LONG), tmp_path_factory.mktemp("uf") / "a.h5")


def test_a_function_with_a_name_of_sixty_characters_is_located(whole):
    assert len(LONG) == 60
    step = whole.step("c")
    assert labels(step) == ["UF1"]
    assert step.reason(step.row("UF1")) == make_reason(CODE, name=LONG)
    assert describe_reason(step.reason(step.row("UF1"))) == LONG
    assert free_amplitude(parameter(step, "omega", "UF1")) == pytest.approx(0.25, abs=1e-10)
    assert monitor(step, "top", "UF1") == pytest.approx(0.25, abs=1e-12)


def test_it_is_followed_in_two_parameters(whole):
    """The amplitude 1 / |1 - w^2 + i c w| is 1/4 all along; the other function is zero where c = 0.3."""
    step = whole.step("uf")
    assert step.meta["curve"] == LABEL
    assert step.curve_reason == make_reason(CODE, name=LONG)
    omega, c = parameter(step, "omega"), parameter(step, "c")
    assert len(step) > 10
    assert 1 / np.hypot(1 - omega**2, c * omega) == pytest.approx(0.25, abs=1e-10)
    # Its own function is zero everywhere, and no special point.
    assert labels(step) == ["UF1"]
    assert step.reason(step.row("UF1")).values["name"] == "other"
    assert parameter(step, "c", "UF1") == pytest.approx(0.3, abs=1e-11)


class Breaking(Silent):
    """Breaks a run off after so many points of the steps of one name."""

    def __init__(self, name, number):
        self.name, self.number, self.here = name, number, False

    def step(self, name, kind):
        self.here = name == self.name

    def progress(self, text, share=None):
        if self.here:
            self.number -= 1
            if not self.number:
                raise KeyboardInterrupt


@pytest.mark.parametrize(("name", "number"), [("c", 4), ("uf", 1), ("uf", 7)])
def test_a_run_that_is_broken_off_goes_on_to_the_same_numbers(whole, tmp_path, name, number):
    checked, path = plan(run_of(LONG)), tmp_path / "a.h5"
    with pytest.raises(KeyboardInterrupt):
        execute(checked, path, Breaking(name, number))
    broken = read_results(path)
    assert not broken.step(name).done and len(broken.step(name)) < len(whole.step(name))
    execute(checked, path, resume=True)
    for step in ("c", "uf"):
        one, other = whole.step(step), read_results(path).step(step)
        assert one.labels == other.labels and describe_endings(one) == describe_endings(other)
        for key, values in one.points.items():
            assert np.array_equal(values, other.points[key], equal_nan=values.dtype.kind == "f"), key
        for key, values in one.orbits.items():
            assert np.array_equal(values, other.orbits[key], equal_nan=values.dtype.kind == "f"), key


def test_its_name_changes_no_number(whole, tmp_path):
    short = run(run_of("level"), tmp_path / "a.h5")
    for step in ("c", "uf"):
        one, other = whole.step(step), short.step(step)
        assert one.labels == other.labels
        for key, values in one.points.items():
            assert np.array_equal(values, other.points[key], equal_nan=values.dtype.kind == "f"), key


def test_as_a_defining_function_it_is_its_monitor(free_orbit):
    level = parse_monitor(free_orbit.numeric, "level", "max(x) - 0.25")
    function, system = UserFunction(level), PeriodicOrbitSystem(free_orbit.problem, measure_orbit(free_orbit))
    at = system.at(free_orbit.x)
    assert function.evaluate(at) == pytest.approx(free_amplitude(2.0) - 0.25, abs=1e-8)
    assert function.kind == LABEL and function.update_at(at) is function


def test_the_function_that_a_curve_follows_must_be_given_again(free_orbit):
    level = parse_monitor(free_orbit.numeric, "level", "max(x) - 0.25")
    settings = BranchSettings(("omega", "c"), ((1, 3), (0, 1)), MeshRule(8, tol=1e-9), user_functions=(level,))
    system, orbit = settings.make_system(free_orbit)
    define = find_kind(LABEL).define
    found = define(system.at(orbit.x), settings, make_reason(CODE, name="level"))
    assert found.monitor is level
    with pytest.raises(StartError, match=r"the user function 'gone' is zero; give it in 'events_along' here too"):
        define(system.at(orbit.x), settings, make_reason(CODE, name="gone"))
