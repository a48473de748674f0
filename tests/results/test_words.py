"""Reasons are told in words, whatever is recorded of them."""

import pytest

from pddecont.reasons import make_reason
from pddecont.tables import describe_reason


@pytest.mark.parametrize(
    ("reason", "words"),
    [
        (make_reason("no_time"), "one of its segments takes no time, or its period is not positive"),
        (make_reason("too_many_steps"), "its simulation takes too many steps"),
        (make_reason("somebodys_own", value=3), "somebodys own (value = 3)"),
    ],
    ids=lambda given: getattr(given, "code", None),
)
def test_a_reason_is_told_in_words(reason, words):
    assert describe_reason(reason) == words
