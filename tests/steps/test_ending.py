"""What is said of the end of a branch."""

from pddecont.tables import describe_endings
from tests.runs import run

RUN = {
    "model": "impact_oscillator",
    "mesh": {"intervals": 12},
    "steps": [
        {"name": "t", "simulate": {"t_end": "60*2*pi/omega"}},
        {"name": "o", "orbit": {"from": "t"}},
        {"name": "one", "continue": {"from": "o", "free": ["a"], "range": {"a": [0.89, 0.91]}, "detect": []}},
    ],
}


def test_the_end_of_a_range_is_named(tmp_path):
    step = run(RUN, tmp_path / "a.h5").step("one")
    assert describe_endings(step) == [
        "down: reached the end of the range, a = 0.89; widen 'range' to go on",
        "up: reached the end of the range, a = 0.91; widen 'range' to go on",
    ]
