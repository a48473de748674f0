"""Segments and events of modes that nothing has reached are found by their names."""

import pytest

from pddecont.model import derived_modes
from tests.conftest import model_from
from tests.model.equations_models import STICK, TWO
from tests.runs import change

KICKED = {**TWO, "jumps": {"kick": {"at": "x - 0.5", "direction": "rising", "reset": {"v": "-v", "w": "w - v"}}}}
RELAY = change(STICK, "equations.v'", "F*cos(om*t) - x - hysteresis(x, -mu, mu) - 0.3*sign(v)")
NESTED = change(STICK, "equations.v'", "F*cos(om*t) - x - mu*sign(v)*max(0, abs(x) - 0.3) - 0.2*sign(v)")
# Names that end like words for digits, and like what happens to switches.
STRANGE = change(KICKED, "switches", {"a": "v", "a_on": "w"})


@pytest.mark.parametrize(
    "text", [STICK, KICKED, RELAY, NESTED, STRANGE], ids=["stick", "kicked", "relay", "nested", "a"]
)
def test_each_part_is_what_it_is_where_all_are_built(text, monkeypatch):
    whole = model_from(text)
    monkeypatch.setattr(derived_modes, "FEW_MODES", 0)
    for kind in ("modes", "events", "resets", "segments"):
        for name, part in getattr(whole, kind).items():
            # Each model anew, so that nothing but the name leads to the part.
            assert getattr(model_from(text), kind)[name] == part, name


@pytest.mark.parametrize(
    "name", ["", "kick", "left_up", "right_below_left_up>left_above", "left_above_right_up>left_on"]
)
def test_what_is_no_segment_is_not_found(name, monkeypatch):
    monkeypatch.setattr(derived_modes, "FEW_MODES", 0)
    model = model_from(KICKED)
    assert name not in model.segments
    assert f"{name}>" not in model.segments
