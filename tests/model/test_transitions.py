"""What can happen in a mode: surfaces, delayed events, clocks, jumps that come back, fields that point at a surface."""

from pddecont.model import list_carriers, list_clocks, list_transitions, may_slide
from tests.conftest import numeric_from
from tests.runs import to_yaml

MODEL = {
    "name": "everything",
    "states": ["x", "y"],
    "parameters": {"tau": 0.3, "long": 2.0, "R": 0.4},
    "modes": {
        "low": {"x'": "1 - x(t - long)", "y'": "-y"},
        "high": {"x'": "-x", "y'": "-y"},
        "hurt": {"x'": "-x", "y'": "0"},
    },
    "events": {
        "level": "x - 1",
        "echo": "x(t - tau) + y(t - long) - 0.5",
        "heal": {"after": "level", "delay": "R"},
        "late": {"after": "heal", "delay": "2*R"},
    },
    "resets": {"push": {"x": "x + 1"}},
    "segments": {
        "up": {"mode": "low", "event": "level", "direction": "rising", "to": "high"},
        "down": {"mode": "low", "event": "level", "direction": "falling", "reset": "push", "to": "low"},
        "cure": {"mode": "low", "event": "heal", "to": "low"},
        "back": {"mode": "high", "event": "level", "direction": "falling", "to": "low"},
        "hear": {"mode": "high", "event": "echo", "direction": "any", "reset": "push", "to": "hurt"},
        "end": {"mode": "hurt", "event": "late", "to": "low"},
        "again": {"mode": "hurt", "event": "level", "direction": "rising", "reset": "push", "to": "low"},
    },
    "initial": {"mode": "low", "x": 0, "y": 0},
}


def model():
    return numeric_from(to_yaml(MODEL)).model


def names(segments):
    return [segment.name for segment in segments]


def test_a_mode_ends_at_surfaces_and_at_delayed_events_in_declared_order():
    low = list_transitions(model(), "low")
    assert (names(low.segments), names(low.crossings), names(low.expiries)) == (
        ["up", "down", "cure"],
        ["up", "down"],
        ["cure"],
    )
    assert {key: s.name for key, s in low.surfaces.items()} == {("level", "rising"): "up", ("level", "falling"): "down"}
    assert low.delayed_events == {"heal"}
    assert list_transitions(model(), "hurt").delayed_events == {"late"}


def test_an_event_starts_the_clocks_that_come_after_it():
    assert list_clocks(model(), "level") == ("heal",)
    assert list_clocks(model(), "heal") == ("late",)
    assert list_clocks(model(), "echo") == ()


def test_a_jump_comes_back_to_functions_that_read_the_state_which_jumps():
    """The push moves x, which `echo` reads tau ago; y does not jump, and `level` reads nothing delayed."""
    found = model()
    delays = [str(found.delays[k]) for k in list_carriers(found, "echo", "push")]
    assert delays == ["tau"]
    assert list_carriers(found, "level", "push") == ()
    assert list_carriers(found, "echo", found.segments["up"].reset) == ()
    assert list_carriers(found, "heal", "push") == ()


def test_both_fields_may_point_at_a_surface_that_the_next_mode_meets_from_its_other_side():
    found = model()
    slides = [name for name, segment in found.segments.items() if may_slide(found, segment)]
    assert slides == ["up", "back", "again"]
