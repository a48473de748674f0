"""Random models with kept seeds: every orbit said to be a motion of its model is one, with its leading multiplier."""

import pytest

from tests.random_models.generator import draw_model
from tests.random_models.trial import try_model

# Seeds whose models show something of each family: walls with delayed resets, kicks, relays, echoes, sampling; sliding
# that begins along a branch (17), impacts that come with the kick that follows them (21), and labelled points at which
# a jump just reaches a level (1035, 1054) or a wall is just touched beside other impacts (1040).
SEEDS = [0, 1, 4, 5, 7, 8, 9, 11, 12, 14, 15, 16, 17, 19, 20, 21, 1035, 1040, 1054]


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_is_wrong_without_a_word(seed, tmp_path, keep_trial):
    trial = try_model(draw_model(seed), tmp_path, every=6, n_decays=1, sweep=seed % 2 == 0)
    keep_trial(trial)
    assert trial.faults == []
    assert trial.refused == []
    assert trial.outcome == "compared"
    assert trial.n_points >= 4
