"""Random models with delays of every kind, kept seeds: their orbits are motions, by calculations apart."""

import pytest

from tests.random_delays.generator import draw_model
from tests.random_delays.trial import try_model

# One of each family.
SEEDS = [0, 1, 2, 3, 4]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_orbits_are_motions(seed, tmp_path):
    trial = try_model(draw_model(seed), tmp_path, max_points=3)
    assert trial.faults == []
    assert trial.outcome == "compared"
    assert trial.n_points >= 3
