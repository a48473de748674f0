"""What is said of how steps with equilibria ended."""

import pytest

from pddecont.reasons import make_reason
from pddecont.results import create_results, read_results
from pddecont.tables import describe_done, describe_endings
from tests.plot.equilibria import FOUND, NEAR, rest, three, write, write_resting
from tests.runs import run


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


UNKNOWN = "the count of characteristic roots does not confirm those that were found: whether it is stable is not known"


@pytest.mark.parametrize(
    ("row", "words"),
    [
        (three()[0], "stable, leading root -0.1 +1i"),
        (three()[1], "unstable (1 root to the right of the imaginary axis), leading root 0.2"),
        (
            three()[2],
            "no root to the right of the imaginary axis, leading root -0.2; WARNING: virtual, its mode does not hold "
            "there",
        ),
        (rest(0, 0.2, 0.0, [-0.5], counted=0), f"leading root -0.5; WARNING: {UNKNOWN}"),
    ],
)
def test_of_one_its_place_and_its_stability_are_said(end, row, words):
    text = end([row], "equilibrium", NEAR)
    x, v = row[0]["states"]
    assert text.startswith(f"x = {x:.10g}, v = {v:.10g} in mode ")
    assert text.endswith(words)


def test_of_many_states_the_first_are_named(tmp_path):
    model = {"states": [f"x{k}" for k in range(9)], "equations": {f"x{k}'": f"{k} - x{k}" for k in range(9)}}
    steps = [{"name": "rest", "equilibrium": {"from": {"x0": 1}}}]
    step = run({"name": "many", **model, "run": {"steps": steps}}, tmp_path / "a.h5").step("rest")
    assert describe_done(step) == (
        "x0 = 0, x1 = 1, x2 = 2, x3 = 3, x4 = 4, x5 = 5 and 3 more states; stable, leading root -1"
    )


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (three(), "all 2 equilibria in the box; also 1 virtual one, where its mode does not hold"),
        (three()[:1], "the only equilibrium in the box"),
        (
            [*three()[:1], rest(0, 0.2, 0.0, [-0.5], counted=0)],
            f"all 2 equilibria in the box; WARNING: at 1 of them {UNKNOWN}",
        ),
        ([], "no equilibrium in the box"),
    ],
)
def test_how_many_were_found_in_a_box(end, rows, words):
    assert end(rows, "equilibrium", FOUND) == words


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
