"""Grids that are made for a solution, and for a guess on which the equations make no sense."""

import numpy as np
import pytest

from pddecont.continuation import MeshNotSettledError, NewtonSettings, correct_component, keep_within, solve_adaptively
from pddecont.continuation.adaptive import FINER, FINER_MESHES, MAX_MESHES
from pddecont.errors import ConvergenceError
from tests.continuation.systems import Growth, circle, grow, start_at


def at_rate(rate, log=None):
    """Return what solves a growth for a rate; ``log`` collects the systems and the vectors that it gets."""

    def solve(system, guess, carried):
        if log is not None:
            log.append((system, guess, carried))
        return correct_component(system, guess, len(guess) - 1, rate, NewtonSettings())

    return solve


def test_a_grid_that_is_fine_enough_is_kept():
    system, log = Growth(8), []
    found, solution = solve_adaptively(system, grow(8, 3.0), at_rate(3.5, log))
    assert found is system and len(log) == 1 and system.asked == []
    assert solution.x == pytest.approx(grow(8, 3.5), abs=1e-12)


def test_a_coarse_grid_is_made_anew_from_the_solution():
    """p = 3.5 wants four intervals for each unit of p, so 14 in place of 4; carried vectors come along."""
    system, log = Growth(4), []
    other = grow(4, 1.0)
    found, solution = solve_adaptively(system, grow(4, 3.0), at_rate(3.5, log), [other])
    assert (found.n, system.asked) == (14, [True])
    assert solution.x == pytest.approx(grow(14, 3.5), abs=1e-11)
    assert [len(carried[0]) for _, _, carried in log] == [6, 16]
    assert log[1][2][0] == pytest.approx(found.interpolate_from(system, other), abs=0)
    # The second guess is the first solution on the new grid.
    assert log[1][1] == pytest.approx(found.interpolate_from(system, grow(4, 3.5)), abs=1e-11)


def test_a_guess_that_makes_no_sense_on_its_grid_is_never_solved_there():
    """p = 5 lies beyond the pole 2n = 4 of the rule on two intervals."""
    system, log = Growth(2), []
    found, solution = solve_adaptively(system, np.array([1.0, 2.0, 4.0, 5.0]), at_rate(5.0, log))
    assert system.asked[0] is False
    assert all(s.mesh_is_valid(s.at(guess)) for s, guess, _ in log)
    assert solution.x == pytest.approx(grow(found.n, 5.0), rel=1e-10)


def test_grids_that_do_not_settle_are_given_up_with_the_last_solution():
    log = []
    with pytest.raises(MeshNotSettledError, match=r"^the grid does not settle$") as caught:
        solve_adaptively(Growth(8, settles=False), grow(8, 3.0), at_rate(3.5, log))
    assert len(log) == MAX_MESHES
    # The solution is the last one, in the unknowns of the system that comes with it.
    assert caught.value.system is log[-1][0]
    assert caught.value.x == pytest.approx(grow(caught.value.system.n, 3.5), abs=1e-11)


def test_a_failure_to_solve_passes_through():
    def fail(system, guess, carried):
        raise ConvergenceError("nothing is found", [1.0])

    with pytest.raises(ConvergenceError, match="nothing is found") as caught:
        solve_adaptively(Growth(8), grow(8, 3.0), fail)
    assert caught.value.history == (1.0,)


def test_a_system_without_a_mesh_is_solved_once():
    state, log = start_at(circle(), [1.0, 0.0], [0.0, 1.0]), []

    def solve(system, guess, carried):
        log.append(carried)
        return correct_component(system, guess, 1, 0.6, NewtonSettings())

    found, solution = solve_adaptively(state.point.system, np.array([0.9, 0.5]), solve, [np.ones(2)])
    assert found is state.point.system and len(log) == 1
    assert solution.x == pytest.approx([0.8, 0.6], abs=1e-14)


@pytest.mark.parametrize("errors", [[0.5], [3.0, 0.9], [3.0, 5.0, 2.0, 1.0], [None, 0.1], [np.inf, 0.1]])
def test_finer_meshes_are_tried_until_an_error_is_small(errors):
    """What is found is named by its error; each mesh asks for more than the one before that did not do."""
    asked = []

    def solve_finer(found, error):
        asked.append((found, error))
        return errors[len(asked)]

    found = keep_within(1.0, errors[0], lambda error: error, solve_finer)
    tried = errors[:1] if errors[0] in (None, np.inf) else errors
    best = [min(tried[: k + 1]) for k in range(len(tried) - 1)]
    assert found == (errors[0] if errors[0] is None else min(tried))
    assert asked == [(error, FINER**k * error) for k, error in enumerate(best)]


def test_of_meshes_that_do_not_help_the_best_is_kept():
    asked = []
    assert keep_within(1.0, 2.0, lambda error: error, lambda found, error: asked.append(error) or 3.0) == 2.0
    assert len(asked) == FINER_MESHES


def test_where_a_finer_mesh_has_no_solution_the_coarse_one_stays():
    def fail(found, error):
        raise ConvergenceError("nothing there")

    assert keep_within(1.0, 2.0, lambda error: error, fail) == 2.0
