import pytest

from pddecont.errors import PddecontError
from pddecont.model.builder import load_model
from pddecont.model.effects import without
from tests.conftest import ROOT

MODEL = load_model(str(ROOT / "models" / "impact_oscillator.yaml"))[0]


def test_feedback_off_takes_the_delay_along():
    left, out = without(MODEL, ["feedback"])
    assert left.delays == ()
    assert left.delayed == ()
    assert out.delays == ("tau_d",)
    assert not any("K" in str(e) for e in left.modes["NC"])


def test_impact_off_takes_the_contact_mode_along():
    left, out = without(MODEL, ["impact"])
    assert list(left.modes) == ["NC"]
    assert left.smooth
    assert (out.events, out.modes) == (("impact",), ("C",))


def test_an_unknown_effect():
    with pytest.raises(PddecontError, match="did you mean 'damping'"):
        without(MODEL, ["dampin"])
