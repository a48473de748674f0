"""What is said of how steps with equilibria ended."""

import pytest

from pddecont.reasons import make_reason
from pddecont.results import create_results, read_results
from pddecont.tables import describe_done, describe_endings
from tests.plot.equilibria import FOUND, rest, three, write, write_resting


@pytest.fixture
def end(tmp_path):
    """Return a function that says how a step with such rows ended."""

    def describe(rows, kind, ending):
        path = tmp_path / "a.h5"
        path.unlink(missing_ok=True)
        create_results(path, "m", "r", "r", "{}")
        write(path, "b", rows, kind=kind, ending=ending)
        return describe_done(read_results(path).step("b"))

    return describe


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (three()[:1], "1 equilibrium: stable, leading root -0.1+1i"),
        (three()[1:2], "1 equilibrium: unstable (1 root to the right of the imaginary axis), leading root 0.2"),
        (
            three()[2:],
            "1 equilibrium: virtual: it does not lie in its mode 'high'; no root to the right of the imaginary axis, "
            "leading root -0.2",
        ),
        (
            [rest(0, 0.2, 0.0, [-0.5], counted=0)],
            "1 equilibrium: WARNING: a count of the characteristic roots to the right of the imaginary axis does not "
            "confirm those that were found, and whether the equilibrium is stable is not known, leading root -0.5",
        ),
        (three(), "3 equilibria: 1 stable, 1 unstable, 1 virtual"),
        (
            [*three(), rest(0, 0.2, 0.0, [-0.5], counted=0)],
            "4 equilibria: 1 stable, 1 unstable, 1 of unknown stability, 1 virtual",
        ),
        ([], "no equilibria"),
    ],
)
def test_how_many_were_found_and_how_many_are_stable(end, rows, words):
    text = end(rows, "equilibrium", FOUND)
    assert text == words or text.startswith(f"{words}; WARNING: at 1 of the points")


def test_what_else_is_recorded_of_the_ending_is_said_too(end):
    ending = make_reason("somebodys_own", left=2)
    assert end(three(), "equilibrium", ending) == (
        "3 equilibria: 1 stable, 1 unstable, 1 virtual; somebodys own (left = 2)"
    )


def test_a_branch_goes_through_modes(tmp_path):
    step = read_results(write_resting(tmp_path / "a.h5")).step("resting")
    words = "up: reached the end of the range, K = 0.9; widen 'range' to go on, through the modes [low], [high]"
    assert describe_endings(step) == [words]
    assert describe_done(step) == f"33 points; special: BE1, HB1; {words}"


@pytest.mark.parametrize(
    ("ending", "words"),
    [
        (
            make_reason("special", direction=-1, detail="kind", kind="BT"),
            "ends at a special point (BT, Bogdanov-Takens)",
        ),
        (
            make_reason("step_too_small", direction=-1),
            "the step fell below 'step: {min}'; look at the last equilibria for an event surface or a sharp fold, or "
            "lower 'step: {min}'",
        ),
        (make_reason("impossible", direction=-1), "can go no further in this mode"),
        (
            make_reason("max_points", direction=-1, unexplained=1),
            "reached 'max_points'; raise it, or 'step: {max}', to go on; WARNING: 1 change of stability not located: "
            "take smaller steps",
        ),
    ],
)
def test_how_a_direction_ended_is_said_of_equilibria(end, ending, words):
    assert end([rest(0, 0.2, 0.0, [-1.0])], "equilibria", ending) == f"1 points; special: none; down: {words}"
