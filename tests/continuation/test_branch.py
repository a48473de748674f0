"""Continuation on curves known in closed form; nothing of models or orbits."""

import math

import numpy as np
import pytest

from pddecont.continuation.arclength import Metric, tangent
from pddecont.continuation.branch import NO_MARGINS, State, StepSettings, follow
from pddecont.continuation.ending import End
from pddecont.continuation.margin import Margins
from pddecont.continuation.newton import newton
from pddecont.continuation.special import Census, TestFunction, Watch
from pddecont.errors import ConvergenceError


class Circle:
    def residual(self, x):
        return np.array([x[0] ** 2 + x[1] ** 2 - 1])

    def jacobian(self, x):
        return np.array([[2 * x[0], 2 * x[1]]])

    def metric(self):
        return Metric(np.ones(2), np.ones(2))

    def outline(self, x):
        return x

    def outline_index(self):
        return np.arange(2)

    def forbids(self, x):
        return ""

    def holds(self, x):
        return True

    def suits(self, x):
        return True

    def carry(self, other, x):
        return x

    def rephased(self, x):
        return self


def run(bounds, tests=(), sign=1, census=None, margins=NO_MARGINS, **settings):
    problem, points = Circle(), []
    x = np.array([-1.0, 0.0])
    direction = tangent(problem, x, problem.metric(), np.array([0.0, sign]))
    options = StepSettings(max_points=settings.pop("max_points", 200), **settings)
    state, watch = State(problem, x, direction, 0.0, options.initial, 1), Watch(list(tests), census)
    end = follow(state, bounds, watch, options, points.append, sign, margins)
    return points, end


def test_points_lie_on_the_branch_and_arclength_is_right():
    points, end = run([(0, -2.0, 2.0)], max_points=100, max=0.05)
    assert end.end is End.MAX_POINTS
    assert len(points) == 99
    for point in points:
        x = point.state.x
        assert math.hypot(*x) == pytest.approx(1, abs=1e-12)
        angle = (math.pi - math.atan2(x[1], x[0])) % (2 * math.pi)
        assert point.state.arclength % (2 * math.pi) == pytest.approx(angle, rel=2e-3)


def test_it_passes_folds_and_ends_exactly_at_the_bound():
    points, end = run([(1, -0.5, 2.0)])
    assert end.end is End.RANGE
    assert points[-1].kind == "EP"
    assert points[-1].state.x == pytest.approx([math.sqrt(0.75), -0.5], abs=1e-12)
    assert max(p.state.x[1] for p in points) > 0.99


MARGIN = Margins(lambda _, x: (np.array([x[0] ** 2 + x[1]]), np.array([[2 * x[0], 1.0]])), lambda _, x, k: f"margin {k} is used up")


@pytest.mark.parametrize(("sign", "side"), [(1, 1), (-1, -1)])
def test_a_branch_ends_exactly_where_a_margin_is_used_up(sign, side):
    """Where x0**2 + x1 = 0 on the circle, x1 = (1 - sqrt(5)) / 2, on the way round from x = (-1, 0)."""
    points, end = run([(0, -2.0, 2.0)], sign=sign, margins=MARGIN)
    assert (end.end, end.detail) == (End.LIMIT, "margin 0 is used up")
    low = 0.5 * (1 - math.sqrt(5))
    assert points[-1].kind == "EP"
    assert points[-1].state.x == pytest.approx([side * math.sqrt(1 - low**2), low], abs=1e-12)
    assert all(p.state.x[0] ** 2 + p.state.x[1] > -1e-12 for p in points)


def test_a_bound_before_the_end_of_a_margin_counts_first():
    points, end = run([(1, -0.6, 2.0)], margins=MARGIN, initial=0.3, max=0.3)
    assert end.end is End.RANGE
    assert points[-1].state.x[1] == pytest.approx(-0.6, abs=1e-12)


def test_a_branch_that_starts_where_a_margin_is_used_up_has_no_other_point():
    used = Margins(lambda _, x: (x[1:], np.array([[0.0, 1.0]])))
    points, end = run([(0, -2.0, 2.0)], sign=-1, margins=used)
    assert (end.end, points) == (End.LIMIT, [])


def test_a_test_function_is_located():
    test = TestFunction("GR", lambda at: at.x[0] - 0.3, stops=True)
    points, end = run([(0, -2.0, 2.0)], [test])
    assert end.end is End.SPECIAL
    assert points[-1].kind == "GR"
    assert points[-1].state.x == pytest.approx([0.3, math.sqrt(0.91)], abs=1e-11)


def test_a_jump_through_zero_is_not_a_special_point():
    test = TestFunction("GR", lambda at: 1.0 if at.x[0] > 0.3 else -1.0, stops=True)
    points, end = run([(0, -2.0, 0.9)], [test])
    assert end.end is End.RANGE
    assert [p.kind for p in points if p.kind] == ["EP"]


def test_two_specials_in_one_step_come_in_order():
    tests = [TestFunction("B", lambda at: at.x[0] - 0.02), TestFunction("A", lambda at: at.x[0] + 0.02)]
    points, _ = run([(0, -2.0, 0.9)], tests, max=0.2)
    assert [p.kind for p in points if p.kind] == ["A", "B", "EP"]


def crossings(*places):
    """Return a census of how many of ``places`` in y lie below the point, each change of one explained, and its calls."""
    def count(at):
        return (sum(at.x[1] > y for y in places),)

    def nearest(at):
        passed = sum(at.x[1] > y for y in places)
        return (-1.0) ** passed * min(abs(at.x[1] - y) for y in places)

    return Census(count, lambda a, b: [TestFunction("N", nearest)] if abs(a[0] - b[0]) == 1 else None)


@pytest.mark.parametrize("places", [(0.2,), (0.2, 0.21), (0.2, 0.2001, 0.201), (0.35, 0.1, 0.1004)])
def test_the_census_is_explained_even_where_several_changes_fall_in_one_step(places):
    points, _ = run([(0, -2.0, 0.0)], census=crossings(*places), max=0.4, initial=0.4)
    found = [p.state.x[1] for p in points if p.kind == "N"]
    assert found == pytest.approx(sorted(places), abs=1e-11)


def test_a_branch_that_stops_existing_says_so():
    class Ends(Circle):
        def residual(self, x):
            return np.array([np.nan]) if x[0] > 0 else super().residual(x)

    problem, points = Ends(), []
    x = np.array([-1.0, 0.0])
    settings = StepSettings()
    end = follow(State(problem, x, np.array([0.0, 1.0]), 0.0, 0.02, 1), [(0, -2.0, 2.0)], Watch(), settings, points.append, 1)
    assert end.end is End.STEP_TOO_SMALL
    assert "refine 'mesh'" in str(end)
    assert -1e-4 < points[-1].state.x[0] <= 0


def test_newton_converges_quadratically_and_keeps_its_history():
    solution = newton(lambda x: x**2 - 2, lambda x: np.diag(2 * x), np.array([1.0]), np.ones(1))
    assert solution.x[0] == pytest.approx(math.sqrt(2), abs=1e-15)
    errors = solution.history
    assert errors[3] < 10 * errors[2] ** 2


def test_newton_damps_where_a_full_step_overshoots():
    solution = newton(lambda x: np.arctan(x), lambda x: np.diag(1 / (1 + x**2)), np.array([3.0]), np.ones(1))
    assert solution.x[0] == pytest.approx(0, abs=1e-12)


def test_failures_carry_their_history():
    with pytest.raises(ConvergenceError) as info:
        newton(lambda x: x**2 + 1, lambda x: np.diag(2 * x), np.array([1.0]), np.ones(1))
    assert len(info.value.history) >= 1
    with pytest.raises(ConvergenceError, match="singular"):
        newton(lambda x: x + 1, lambda x: np.zeros((1, 1)), np.array([1.0]), np.ones(1))
