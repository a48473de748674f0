"""Random models with fresh seeds: as many as PDDECONT_MODELS says, from PDDECONT_SEED or a new one."""

import os
import secrets

import pytest

from tests.random_models.generator import draw_model
from tests.random_models.trial import try_model

FIRST = int(os.environ.get("PDDECONT_SEED", 0)) or 1000 + secrets.randbelow(10**8)
NUMBER = int(os.environ.get("PDDECONT_MODELS", 9))
BATCH = 9


@pytest.mark.slow
@pytest.mark.parametrize("batch", range(-(-NUMBER // BATCH)))
def test_nothing_is_wrong_without_a_word(batch, tmp_path, keep_trial):
    first = FIRST + batch * BATCH
    seeds, wrong = range(first, min(first + BATCH, FIRST + NUMBER)), []
    print(f"to repeat: PDDECONT_SEED={first} PDDECONT_MODELS={len(seeds)}")
    for seed in seeds:
        model = draw_model(seed)
        trial = try_model(model, tmp_path)
        keep_trial(trial)
        wrong += [f"seed {seed}, {model.family}: {' | '.join(fault)}" for fault in trial.faults]
    assert not wrong, "\n".join(wrong)
