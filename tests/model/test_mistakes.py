"""Common mistakes are told by what was meant."""

import ast

import pytest

from pddecont.model.mistakes import find_derivative, is_infinite, is_moment, suggest_point


@pytest.mark.parametrize("text", ["nan", ".nan", "-.inf", "+inf", " Infinity "])
def test_words_for_what_is_not_finite_are_known(text):
    assert is_infinite(text)
    assert not is_infinite(text.strip() + "x")


@pytest.mark.parametrize(
    ("text", "meant"), [("0,8", "0.8"), (" -12,5", "-12.5"), ("1,2,3", ""), ("a,8", ""), ("8", "")]
)
def test_a_comma_between_digits_is_meant_as_a_point(text, meant):
    assert suggest_point(text) == (f"; write a decimal point, {meant}" if meant else "")


@pytest.mark.parametrize(
    ("text", "words", "place"), [("-x2' - tau", "x2' is a derivative", 1), ("1 + v' + x", "v' is a derivative", 4)]
)
def test_derivatives_are_found_where_they_stand(text, words, place):
    message, offset = find_derivative(text)
    assert message.startswith(words)
    assert offset == place
    assert find_derivative(text.replace("'", "")) is None


@pytest.mark.parametrize(("text", "expected"), [("t", True), ("t - 2*tau", True), ("omega*t", False), ("x", False)])
def test_a_time_is_told_from_other_arguments(text, expected):
    assert is_moment(ast.parse(text, mode="eval").body) == expected
