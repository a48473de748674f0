"""Random models with delays of every kind: the same for a seed, read by the program, of every kind."""

import pytest

from tests.conftest import model_from
from tests.random_delays.generator import FAMILIES, draw_model

SEEDS = range(4 * len(FAMILIES))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_seed_gives_the_same_model_again_which_is_read(seed):
    drawn = draw_model(seed)
    assert drawn == draw_model(seed)
    model = model_from(drawn.as_mapping())
    assert set(model.modes) == set(drawn.modes)
    written = " ".join(str(f.yaml) for flow in drawn.modes.values() for f in flow.values())
    assert ("neutral" in drawn.kinds) == ("'(t - " in written)
    assert ("remembered" in drawn.kinds) == any(s.startswith("memory") for s in model.states)


def test_all_kinds_are_drawn():
    kinds = {kind for seed in range(40 * len(FAMILIES)) for kind in draw_model(seed).kinds}
    assert kinds == {"by a state", "nested", "in time", "neutral", "distributed", "limit that varies", "remembered"}
