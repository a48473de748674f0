"""Random models of equations with kept seeds: motions are those of the reference, and of the models by hand."""

import collections

import pytest

from tests.random_equations.generator import draw_equations
from tests.random_equations.trial import try_equations

# All kinds of functions, long and short sliding, impacts with kicks, delayed values; guards that compile in a second. A
# jump in 132 moves the value that is compared in a function within another, whose own digit it changes.
SEEDS = [9, 21, 26, 41, 44, 50, 55, 57, 85, 106, 125, 132, 146, 163, 169, 175]
# Of each batch of two hundred models at least a third is compared; the others are large, unsure, or refused.
N_SEEDS, BATCH = 200, 20


@pytest.mark.parametrize("seed", SEEDS)
def test_the_program_moves_as_the_reference(seed):
    trial = try_equations(draw_equations(seed))
    assert (trial.outcome, trial.why) == ("compared", "")


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, N_SEEDS, BATCH))
def test_none_of_many_moves_otherwise(first):
    trials = [try_equations(draw_equations(seed)) for seed in range(first, first + BATCH)]
    outcomes = collections.Counter(t.outcome for t in trials)
    print(f"seeds {first} to {first + BATCH - 1}: {dict(outcomes)}")
    wrong = {t.seed: t.why for t in trials if t.outcome == "wrong"}
    assert not wrong
    assert outcomes["compared"] >= BATCH // 3
