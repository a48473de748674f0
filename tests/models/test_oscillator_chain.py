"""The shipped chain of oscillators is the one that its generator writes."""

from models.oscillator_chain import chain
from pddecont.model import load_model
from pddecont.model.system import make_symbol
from tests.conftest import ROOT


def test_the_shipped_chain_is_the_generators_and_couples_neighbours_alike():
    """Each velocity's slope changes with the places of its neighbours by c, with its own by -1 - 2 c."""
    text = (ROOT / "models" / "oscillator_chain_50.yaml").read_text()
    assert text == chain(50)
    model = load_model(str(ROOT / "models" / "oscillator_chain_50.yaml"))[0]
    c, x = make_symbol("c"), [make_symbol(f"x{i}") for i in range(1, 51)]
    for i, field in enumerate(model.modes["free"][1::2]):
        for j in range(50):
            assert field.diff(x[j]) == (-1 - 2 * c if i == j else c if abs(i - j) == 1 else 0), (i, j)
