"""Many random models: one that takes too long is given up and counted."""

import time

import pytest

from tests.random_models.driver import try_within
from tests.random_models.generator import draw_model
from tests.random_models.program import TOO_LONG, Trial
from tests.random_models.tables import COLUMNS, summarise_trials


def work_for_ever(model, folder):
    while True:
        try:
            time.process_time()
        except Exception as error:  # as parts of a trial do
            return Trial(model.seed, model.family, why=str(error))


def test_a_model_that_takes_too_long_is_given_up_and_counted(tmp_path):
    trial = try_within(work_for_ever, draw_model(3), tmp_path, limit=0.05)
    assert trial.outcome == TOO_LONG
    (head, lines), _ = summarise_trials([vars(trial)])
    assert head == list(COLUMNS)
    assert lines[-1][COLUMNS.index("given up")] == "1"
    assert lines[-1][COLUMNS.index("with an orbit")] == "0"


@pytest.mark.parametrize("outcome", ["compared", "no orbit"])
def test_another_is_what_it_is(tmp_path, outcome):
    trial = try_within(lambda model, _: Trial(model.seed, model.family, outcome), draw_model(3), tmp_path, limit=60.0)
    assert trial.outcome == outcome
    (_, lines), _ = summarise_trials([vars(trial)])
    assert lines[-1][COLUMNS.index("given up")] == "0"
