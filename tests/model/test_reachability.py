"""Segments and modes that no motion can come to are told by ``check``."""

import pytest

from pddecont.errors import ModelError
from pddecont.model import Segment, parse_document, parse_model
from pddecont.model.reachability import find_shadowed, find_unreached
from tests.runs import to_yaml


def make_segment(name, mode, direction, to, event="turn"):
    return Segment(name, mode, event, direction, "identity", to)


@pytest.mark.parametrize(
    ("above", "direction", "is_shadowed"),
    [
        (["falling"], "falling", True),
        (["any"], "rising", True),
        (["rising", "falling"], "any", True),
        (["any"], "any", True),
        (["rising"], "falling", False),
        (["rising"], "any", False),
    ],
)
def test_a_segment_is_shadowed_where_others_end_at_all_it_ends_at(above, direction, is_shadowed):
    others = [make_segment(f"S{k}", "a", way, "b") for k, way in enumerate(above)]
    found = list(find_shadowed([*others, make_segment("last", "a", direction, "c")]))
    assert [name for name, _ in found] == (["last"] if is_shadowed else [])


def test_segments_of_other_modes_and_events_shadow_nothing():
    segments = [make_segment("A", "a", "any", "b"), make_segment("B", "b", "any", "a")]
    assert not list(find_shadowed([*segments, make_segment("C", "a", "any", "c", "other")]))


def test_modes_that_only_lead_to_one_another_are_not_reached():
    segments = [
        make_segment("A", "a", "any", "b"),
        make_segment("B", "b", "any", "a"),
        make_segment("C", "c", "any", "d"),
        make_segment("D", "d", "any", "c"),
    ]
    found = dict(find_unreached("a", ["a", "b", "c", "d", "e"], segments))
    assert set(found) == {"c", "d", "e"}
    assert "only others like it lead to it" in found["c"]
    assert found["e"] == "no segment leads to mode 'e'"


STICKING = {
    "name": "sticking",
    "states": ["x", "v"],
    "parameters": {"f": 1.5},
    "modes": {"plus": {"x'": "v", "v'": "f - x"}, "minus": {"x'": "v", "v'": "-f - x"}, "stick": {"x'": 0, "v'": 0}},
    "events": {"turn": "v", "off": "x - f"},
    "segments": {
        "P": {"mode": "plus", "event": "turn", "direction": "falling", "to": "minus"},
        "PS": {"mode": "plus", "event": "turn", "direction": "falling", "to": "stick"},
        "M": {"mode": "minus", "event": "turn", "direction": "rising", "to": "plus"},
        "S": {"mode": "stick", "event": "off", "direction": "rising", "to": "plus"},
    },
}


def test_two_segments_alike_are_an_error_at_the_second():
    with pytest.raises(ModelError, match="segment 'PS' can never happen: 'P' above ends mode 'plus'") as caught:
        parse_model(parse_document(to_yaml(STICKING), "m.yaml"))
    assert len(caught.value.problems) == 1


def test_a_mode_that_is_not_reached_is_worth_a_word():
    segments = {name: body for name, body in STICKING["segments"].items() if name != "PS"}
    _, warnings = parse_model(parse_document(to_yaml({**STICKING, "segments": segments}), "m.yaml"))
    assert [w.message for w in warnings] == ["no segment leads to mode 'stick'"]
