"""What files of format 2 said in sentences, as data."""

import itertools

import h5py
import numpy as np
import pytest

from pddecont.reasons import Reason, make_reason, reason_from_json
from pddecont.results import read_results
from pddecont.results.format import FORMAT_VERSION
from pddecont.results.upgrade import upgrade_step
from pddecont.results.whole_file import upgrade_results
from pddecont.simulate import FailureReason, MotionFailure, failure_from_reason
from tests.runs import run
from tests.simulate.test_failure import SENTENCES

USERS = '{"step": {"continue": {"events_along": {"a_user_function_whose_name_is_longer_than_32_bytes": "x"}}}}'


def reasons_of(kind, labels, notes, meta=None):
    """Return the reasons that a step's notes become."""
    points = {"kind": np.array(labels, dtype="S8"), "note": np.array([n.encode() for n in notes], dtype="S400")}
    points, orbits, _ = upgrade_step(kind, meta or {}, points, {}, [])
    assert list(points) == ["kind"]
    ends = [0, *orbits["reason_end"]]
    packed = orbits["reason"].tobytes().decode()
    return [reason_from_json(packed[a:b]) for a, b in itertools.pairwise(ends)]


# That of a motion that both fields push off a surface came with format 4, those of delays that vary later.
LATER = {FailureReason.REPELLED, FailureReason.ADVANCED, FailureReason.PAST_UNKNOWN, FailureReason.PAST_TOO_LONG}


@pytest.mark.parametrize("reason", [r for r in FailureReason if r not in LATER])
def test_failures_of_motions_keep_their_reason_event_and_sentence(reason):
    cut = SENTENCES[reason][:200]
    [found] = reasons_of("sweep", [""], [cut])
    event = "hit" if "hit" in cut else None
    assert failure_from_reason(found).is_like(MotionFailure(reason, 9.0, event))
    assert found.values["text"] == cut


@pytest.mark.parametrize(
    ("kind", "note", "reason"),
    [
        ("", "", Reason()),
        ("UF", "u", make_reason("user_function", name="u")),
        (
            "UF",
            "a_user_function_whose_name_is_lo",
            make_reason("user_function", name="a_user_function_whose_name_is_longer_than_32_bytes"),
        ),
        ("PD", "halves become equal", make_reason("halves_equal")),
        ("GG", "grazing", make_reason("grazing")),
        ("VS", "hit meets meets", make_reason("meeting", event="hit", other="meets")),
        ("VS", "flight vanishes", make_reason("vanishing", segment="flight")),
        ("VS", "event turns tangential", make_reason("tangential")),
        ("GR", "something else", make_reason("text", text="something else")),
    ],
)
def test_notes_of_special_points(kind, note, reason):
    assert reasons_of("continue", [kind], [note], {"settings": USERS}) == [reason]


def test_a_file_of_format_3_says_of_no_orbit_that_it_is_none(tmp_path):
    """It lacks what was not known then; gone on with it says that it is not known."""
    path = tmp_path / "a.h5"
    branch = {"from": "o", "free": ["omega"], "range": {"omega": [1.9, 2.1]}, "stability": True}
    steps = [{"name": "t", "simulate": {"t_end": 120}}, {"name": "o", "orbit": {"from": "t", "stability": True}}]
    steps.append({"name": "b", "continue": {**branch, "max_points": 3}})
    new = run({"model": "wall_oscillator", "steps": steps}, path).step("b")
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 3
        for name in ("o", "b"):
            for key in ("verified", "deviation", "unexplained"):
                file[f"steps/{name}/points"].pop(key, None)
            for key in ("residual", "residual_end"):
                del file[f"steps/{name}/orbits/{key}"]
    for upgraded in (False, True):
        step = read_results(path).step("b")
        assert np.all(step.points["verified"] == -1) and np.all(np.isnan(step.points["deviation"]))
        assert np.all(np.isnan(step.orbits["residual"])) and len(step.orbits["residual"])
        assert np.all(step.points["unexplained"] == 0)
        assert np.array_equal(step.points["parameters"], new.points["parameters"])
        assert (read_results(path).version == FORMAT_VERSION) == upgraded
        upgrade_results(read_results(path))


def test_endings_keep_their_direction():
    _, _, endings = upgrade_step("continue", {}, {}, {}, [b"down: reached it", b"up: reached it", b"done"])
    assert [ending.values["direction"] for ending in endings] == [-1, 1, 0]
    assert [ending.values["text"] for ending in endings] == ["down: reached it", "up: reached it", "done"]


def test_methods_of_a_comparison_become_fields():
    families = ["direct", "direct, not tracked", "chebyshev", "chain of order 3", "chain of order 12, explicit states"]
    points = {
        "family": np.array([f.encode() for f in families], dtype="S40"),
        "setting": np.array([b"s"] * len(families), dtype="S40"),
    }
    points, _, _ = upgrade_step("precision", {}, points, {}, [])
    assert [m.decode() for m in points["method"]] == ["direct", "direct", "chebyshev", "chain", "chain"]
    assert points["tracked"].tolist() == [1, 0, 1, 1, 1]
    assert points["order"].tolist() == [0, 0, 0, 3, 12]
    assert points["explicit"].tolist() == [0, 0, 0, 0, 1]
