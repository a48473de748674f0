"""Names that stand for two things, for nothing, or that nothing uses are found with their places."""

import sympy

from pddecont.model.names import collect_symbols, find_clashes, find_strange_units, find_unused_parameters
from pddecont.model.parts import Event
from pddecont.model.schema import ModelFile

FILE = {
    "name": "m",
    "states": ["x"],
    "parameters": {"a": 1, "b": 2, "c": 3},
    "modes": {"m": {"x'": "-a*x"}},
    "effects": {"spring": {"set": {"c": 0}}},
}


def read(**changes):
    return ModelFile.model_validate({**FILE, **changes})


def test_a_name_that_stands_for_two_things_is_found_at_the_second():
    ((path, message),) = find_clashes(read(definitions={"a": "2*b"}))
    assert path == ("definitions", "a")
    assert message.startswith("'a' stands already among the parameters")
    assert [path for path, _ in find_clashes(read(states=["x", "x"]))] == [("states", 1)]
    assert not list(find_clashes(read()))


def test_units_of_nothing_are_found():
    ((path, message),) = find_strange_units(read(units={"x": "m", "t": "s", "aa": "N"}))
    assert path == ("units", "aa")
    assert "did you mean 'a'" in message


def test_a_parameter_is_used_in_an_expression_or_by_an_effect():
    assert [path for path, _ in find_unused_parameters(read(), {sympy.Symbol("a")})] == [("parameters", "b")]


def test_symbols_are_those_of_functions_and_delays():
    x, a, b = sympy.symbols("x a b")
    events = {"hit": Event("hit", x - a), "late": Event("late", None, "hit", b)}
    assert collect_symbols({"m": (a * x,)}, events, {}, [], None) == {
        ("modes", "m"): {a, x},
        ("events", "hit"): {a, x},
        ("events", "late"): {b},
        ("forcing",): set(),
    }
