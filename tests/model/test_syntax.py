"""Texts become syntax trees that know where each part was written, whatever it is called."""

import ast

import pytest

from pddecont.model.syntax import ExpressionError, describe_node, parse_syntax, unmask


def test_words_of_python_are_names_and_stay_in_their_columns():
    tree = parse_syntax("  lambda + is*x")
    names = {unmask(node.id): node.col_offset for node in ast.walk(tree) if isinstance(node, ast.Name)}
    assert names == {"lambda": 2, "is": 11, "x": 14}


@pytest.mark.parametrize(("text", "offset"), [("", 0), ("a +", 3), ("2 ? 3", 2), ("1 + v'", 4)])
def test_what_is_no_expression_is_told_where(text, offset):
    with pytest.raises(ExpressionError) as told:
        parse_syntax(text)
    assert told.value.offset == offset


@pytest.mark.parametrize(("text", "words"), [("a, b", "a tuple (a comma)"), ("a.b", "a dot"), ("a < b", "comparison")])
def test_what_may_not_stand_in_an_expression_has_a_name(text, words):
    assert words in describe_node(parse_syntax(text))
