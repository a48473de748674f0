"""How branches end: codes that files hold and that tables have words for."""

import pytest

from pddecont.continuation import End, Termination
from pddecont.reasons import NO_REASON, make_reason
from pddecont.tables.branch_endings import BRANCH_ENDS, describe_branch_end


@pytest.mark.parametrize("end", End)
def test_a_code_is_the_text_that_files_hold_and_tables_explain(end):
    assert str(end) == end.value == end
    assert end in BRANCH_ENDS
    assert describe_branch_end(end, NO_REASON).startswith(BRANCH_ENDS[end][0])


def test_an_ending_says_no_more_than_it_is_given():
    assert Termination(End.MAX_POINTS) == Termination("max_points", NO_REASON, 0)


def test_detail_and_what_was_not_explained_are_told():
    end = Termination(End.RANGE, make_reason("range", parameter="K", value=0.3), 2)
    assert describe_branch_end(end.end, end.detail, end.n_unexplained) == (
        "reached the end of the range, K = 0.3; widen 'range' to go on; WARNING: 2 changes of stability not located: "
        "take smaller steps"
    )


def test_a_test_function_may_end_a_branch_with_a_code_of_its_own():
    assert describe_branch_end(Termination("my_own_end").end, NO_REASON) == "my own end"
