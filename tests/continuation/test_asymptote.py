"""Branches that run along asymptotes, and those that only look like it: curves in (x, p) known in closed form."""

from dataclasses import dataclass

import numpy as np
import pytest

from pddecont.continuation import Approach, End, StepSettings, TestFunction, TestFunctions, asymptote, follow_branch
from pddecont.continuation.arclength import solve_with_row
from pddecont.reasons import make_reason
from tests.continuation.systems import Algebraic, Range, circle, fold, line, start_at

LIMIT = 0.3
# How small a damping is found out by orbits a thousand times as large as the one that is looked ahead from.
DAMPING = 1e-4


@dataclass(frozen=True)
class Wall:
    """Beyond x = ``top`` there are no equations."""

    top: float
    approach: Approach = Approach.TOWARDS
    end: str = End.IMPOSSIBLE

    def margins(self, at):
        return np.array([self.top - at.x[0]])

    def gradients(self, at):
        return np.array([[-1.0, 0.0]])

    def reason(self, at, k):
        return make_reason("range", parameter="x", value=self.top)


@dataclass(frozen=True)
class Modulus:
    """The modulus of x may grow; p is the free parameter, which began at ``origin``."""

    origin: np.ndarray

    def sizes(self, at):
        return np.abs(at.x[:1])

    def rows(self, at):
        return np.array([[np.sign(at.x[0]), 0.0]])

    def find_parameters(self, at):
        return slice(1, 2)

    def is_lost(self, violation):
        return False

    def reason(self, at, k, limits, errors):
        return make_reason("grows", value=float(at.x[0]), limit=float(limits[0]), error=float(errors[0]))


def pole(power, **changes):
    """x = (p - 0.3)^-1/power, the curve of all p above the limit."""
    return Algebraic(
        lambda x: [(x[1] - LIMIT) * x[0] ** power - 1.0],
        lambda x: [[power * (x[1] - LIMIT) * x[0] ** (power - 1.0), x[0] ** power]],
        **changes,
    )


def logarithm(rate=1.0):
    """x = 1 - log(p - 0.3) / rate."""
    return Algebraic(
        lambda x: [x[1] - LIMIT - np.exp(rate * (1.0 - x[0]))], lambda x: [[rate * np.exp(rate * (1.0 - x[0])), 1.0]]
    )


def resonance(damping):
    """x^2 ((p - 0.3)^2 + damping^2) = 1."""
    return Algebraic(
        lambda x: [x[0] ** 2 * ((x[1] - LIMIT) ** 2 + damping**2) - 1.0],
        lambda x: [[2.0 * x[0] * ((x[1] - LIMIT) ** 2 + damping**2), 2.0 * x[0] ** 2 * (x[1] - LIMIT)]],
    )


def slow():
    """p = tanh(x - 9) + x / 1000: the parameter comes nearly to rest, and goes on."""
    return Algebraic(
        lambda x: [x[1] - np.tanh(x[0] - 9.0) - 1e-3 * x[0]], lambda x: [[np.tanh(x[0] - 9.0) ** 2 - 1.0 - 1e-3, 1.0]]
    )


def follow(system, x, towards, *, functions=None, low=-1.0, high=2.0, **settings):
    """Return the points of a branch, and how it ended."""
    options, points = StepSettings(**{"max_points": 400, **settings}), []
    state = start_at(system, x, towards)
    ends, functions = [Range(1, low, high)], functions or TestFunctions()
    return points, follow_branch(state, ends, functions, options, points.append, 1, None, Modulus(np.array(x[1:])))


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("width", [1.0, 1e3])
def test_a_pole_ends_the_branch_and_its_place_is_known(power, width):
    points, end = follow(pole(power, scale=(1.0, width)), [1.0, 1.3], [1.0, -1.0], high=width + 2.0, max=1.0)
    assert end.end == End.ASYMPTOTE
    assert points[-1].kind == "EP" and points[-1].state.x[0] == end.detail.values["value"]
    assert end.detail.values["limit"] == pytest.approx(LIMIT, abs=1e-10)
    # The branch is followed to where p has come near, whatever its range, and not much farther.
    assert 0.02 < power * (points[-1].state.x[1] - LIMIT) / (1.3 - points[-1].state.x[1]) < 0.05


@pytest.mark.parametrize("rate", [0.2, 1.0, 5.0])
def test_a_logarithm_ends_the_branch_and_its_place_is_known(rate):
    _, end = follow(logarithm(rate), [1.0, 1.3], [1.0, -1.0])
    assert end.end == End.ASYMPTOTE
    assert abs(end.detail.values["limit"] - LIMIT) < min(max(2.0 * end.detail.values["error"], 1e-15), 1e-6)


def test_corrections_to_the_power_are_extrapolated_within_the_error_that_is_told():
    """p = 0.3 + 1/x + 3/x^2."""
    bent = Algebraic(
        lambda x: [x[1] - LIMIT - 1.0 / x[0] - 3.0 / x[0] ** 2], lambda x: [[x[0] ** -2 + 6.0 * x[0] ** -3, 1.0]]
    )
    _, end = follow(bent, [2.0, 1.55], [1.0, -1.0])
    assert end.end == End.ASYMPTOTE
    assert abs(end.detail.values["limit"] - LIMIT) < end.detail.values["error"] < 1e-6


@pytest.mark.parametrize(
    ("system", "x", "towards"),
    [
        (circle(), [0.0, -1.0], [1.0, 0.0]),
        (fold(), [-1.0, 1.0], [1.0, -1.0]),
        (fold(), [0.01, 1e-4], [1.0, 0.0]),
        (line(1e-4), [1.0, 1e-4], [1.0, 0.0]),
        (line(0.01), [1.0, 0.01], [1.0, 0.0]),
        (line(1e6), [1.0, 1e6], [1.0, 0.0]),
        (resonance(0.3), [1.0, LIMIT + np.sqrt(0.91)], [1.0, -1.0]),
        (resonance(0.03), [1.0, LIMIT + np.sqrt(1.0 - 0.03**2)], [1.0, -1.0]),
        (resonance(DAMPING), [1.0, LIMIT + np.sqrt(1.0 - DAMPING**2)], [1.0, -1.0]),
        (Algebraic(lambda x: [x[1] - 0.01 * np.log(x[0])], lambda x: [[-0.01 / x[0], 1.0]]), [1.0, 0.0], [1.0, 0.0]),
        (slow(), [1.0, np.tanh(-8.0) + 1e-3], [1.0, 0.0]),
        (Algebraic(lambda x: [x[1]], lambda x: [[0.0, 1.0]]), [1.0, 0.0], [1.0, 0.0]),
    ],
    ids=["circle", "fold", "root", "flat", "sloping", "steep", "damped", "less", "least", "log", "layer", "family"],
)
def test_ordinary_branches_do_not_end_so(system, x, towards):
    _, end = follow(system, x, towards, max_points=150)
    assert end.end in {End.MAX_POINTS, End.RANGE}


def test_a_limit_outside_the_range_is_none():
    _, end = follow(pole(1.0), [1.0, 1.3], [1.0, -1.0], low=LIMIT + 1e-3, max=1.0)
    assert end.end == End.MAX_POINTS or end.end == End.RANGE


def test_what_happens_on_the_way_is_not_passed_over():
    functions = TestFunctions((TestFunction("T", lambda point: point.at.x[0] - 90.0),))
    points, end = follow(pole(1.0), [1.0, 1.3], [1.0, -1.0], functions=functions, max=1.0)
    assert end.end == End.ASYMPTOTE
    assert [p.kind for p in points if p.kind] == ["T", "EP"]
    assert points[-1].state.x[0] > 90.0


def test_nothing_is_solved_ahead_where_the_equations_fail(monkeypatch):
    """Where x > 40 there are no equations; tangents that lead there are not followed, however steep they are."""
    solved = []

    def spy(system, row, level, guess, settings):
        solved.append(guess[0])
        return solve_with_row(system, row, level, guess, settings)

    monkeypatch.setattr(asymptote, "solve_with_row", spy)
    state = start_at(pole(1.0), [1.0, 1.3], [1.0, -1.0])
    ends = [Range(1, -1.0, 2.0), Wall(40.0)]
    options, horizon = StepSettings(max=1.0), Modulus(np.array([1.3]))
    end = follow_branch(state, ends, TestFunctions(), options, lambda _: None, 1, None, horizon)
    assert end.end == End.IMPOSSIBLE
    assert len(solved) > 0 and max(solved) < 40.0
