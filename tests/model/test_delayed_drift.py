"""How fast delayed values change the functions of switches."""

import pytest

from tests.model.equations_models import one_law


def drift(law, **more):
    """Return the drift of the only switch of x' = law, y' = x(t - 1) - y."""
    (switch,) = one_law(law, **more).derived.equations.switches
    return switch.drift


def test_without_delayed_values_there_is_none():
    assert drift("-sign(x - y)") == 0


def test_the_equation_of_the_delayed_state_is_read_as_much_earlier():
    """y' = x(t - 1) - y, read at t - 2: x(t - 3) - y(t - 2)."""
    model = one_law("-sign(x + 3*y(t - 2))")
    (switch,) = model.derived.equations.switches
    names = {s.name for s in switch.drift.free_symbols}
    assert names == {"x(t - 3)", "y(t - 2)"} <= {s.name for s in model.delayed_symbols}
    assert sorted(float(switch.drift.diff(s)) for s in switch.drift.free_symbols) == [-3.0, 3.0]
    assert model.derived.surfaces.slides == (True,)


@pytest.mark.parametrize(
    ("law", "more"),
    [
        ("-sign(x + x(t - 1))", {}),
        ("-sign(y(t - 1))", {}),
        ("-sign(x + y(t - 1))", {"jumps": {"j": {"at": "x - 2", "reset": {"y": 0}}}}),
    ],
    ids=["the law itself jumps", "delayed values alone", "a jump resets it"],
)
def test_where_it_is_not_known_nothing_slides(law, more):
    model = one_law(law, **more)
    assert drift(law, **more) is None and model.derived.surfaces.slides == (False,)
