"""Random models with delays of every kind, kept seeds: their orbits are motions, by calculations apart."""

import pytest

from tests.random_delays.generator import draw_model
from tests.random_delays.trial import try_model

# Quick ones; the mesh of the last one lacked the jumps that limits of integrals bring back.
QUICK = [5, 6, 10, 12, 11]
# Longer ones, and those that took too long: steps crowded by jumps that limits of integrals
# bring back (7, 8); breaking times so near to one another that a rough guess has them in another order (86).
LONGER = [0, 1, 3, 7, 8, 86]


@pytest.mark.parametrize("seed", [*QUICK, *(pytest.param(seed, marks=pytest.mark.slow) for seed in LONGER)])
def test_orbits_are_motions(seed, tmp_path):
    trial = try_model(draw_model(seed), tmp_path, max_points=3)
    assert trial.faults == []
    assert trial.refused == []
    assert trial.outcome == "compared"
    assert trial.n_points >= 3
