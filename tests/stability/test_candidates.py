"""First guesses of multipliers."""

import numpy as np
import pytest
import scipy.linalg

from pddecont.stability import candidates as module
from pddecont.stability.candidates import find_candidates, is_deep
from pddecont.stability.monodromy import linearise_period
from tests.known_orbits import chained_impact_oscillator, hard_wall
from tests.stability.long_delays import damped_wall


@pytest.mark.parametrize("make", [hard_wall, chained_impact_oscillator])
def test_small_maps_give_all_their_eigenvalues(make):
    monodromy = linearise_period(make())
    exact = scipy.linalg.eigvals(monodromy.to_matrix())
    exact = exact[np.argsort(-np.abs(exact))]
    assert find_candidates(monodromy, 4)[:4] == pytest.approx(exact[:4], abs=1e-9)


def test_arnoldi_finds_the_leading_ones(monkeypatch):
    monodromy = linearise_period(hard_wall())
    whole = find_candidates(monodromy, 4)
    monkeypatch.setattr(module, "DENSE", 0)
    assert find_candidates(monodromy, 4)[:2] == pytest.approx(whole[:2], abs=1e-9)


def test_of_a_long_history_nothing_is_guessed():
    monodromy = linearise_period(damped_wall(5.3, 0.05))
    assert is_deep(monodromy) and not len(find_candidates(monodromy, 12))
