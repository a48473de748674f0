"""The states at rest after impacts that accumulate, and segments that lead to rest."""

import pytest
import sympy

from pddecont.errors import ModelError
from pddecont.model import TIME, add_rests, find_rest, list_alternatives
from pddecont.model.rest import find_push, find_resting
from tests.conftest import model_from
from tests.simulate.motions import BALL

x, v, y, w, r, m = (sympy.Symbol(name, real=True) for name in "xvywrm")
AFTER = (m * w + v - m * r * (v - w)) / (1 + m), (m * w + v + r * (v - w)) / (1 + m)


def test_a_ball_rests_with_its_floor():
    assert find_resting((y, v), v, (y, -r * v)) == (y, 0)


def test_on_a_table_that_moves_a_ball_rests_with_the_table():
    table = sympy.cos(TIME)
    assert find_resting((y, v), v - table, (y, -r * v + (1 + r) * table)) == (y, table)


def test_two_bodies_rest_with_the_speed_of_their_centre_of_mass():
    """Masses 1 and m; the force on the second is that on the first, turned round."""
    rest = find_resting((x, v, y, w), v - w, (x, AFTER[0], y, AFTER[1]))
    assert sympy.simplify(rest[1] - (v + m * w) / (1 + m)) == 0
    assert sympy.simplify(rest[3] - rest[1]) == 0
    assert (rest[0], rest[2]) == (x, y)
    push = find_push((x, v, y, w), v - w, (x, AFTER[0], y, AFTER[1]))
    assert sympy.simplify(push[1] + m * push[3]) == 0
    assert sympy.simplify(push[1] - push[3]) == 1


def test_restitution_may_depend_on_the_speed():
    slower = sympy.exp(v) / 2
    assert find_resting((y, v), v, (y, -slower * v)) == (y, 0)


def test_a_reset_that_leaves_the_speed_alone_leaves_the_states_as_it_makes_them():
    assert find_push((y, v), v, (y, v)) is None
    assert find_resting((y, v), v, (0, v)) == (0, v)


RESTING = BALL.replace("to: fly}", "to: fly, rest: lie}")


def test_a_segment_that_leads_to_rest_is_no_alternative_of_the_impact():
    model = model_from(RESTING)
    hop, rest = model.segments.values()
    assert (hop.name, rest.name, rest.to, rest.rests) == ("hop", "hop>lie", "lie", True)
    assert model.resets["hop>lie"] == (model.state_symbols[0], 0)
    assert list_alternatives(model, hop) == (hop,)
    assert find_rest(model, hop) == find_rest(model, rest) == rest


def test_what_a_run_says_of_rest_is_added_once():
    plain = model_from(BALL)
    assert find_rest(plain, plain.segments["hop"]) is None
    added = add_rests(plain, [("hit", "lie")])
    assert added.segments == model_from(RESTING).segments
    assert add_rests(added, [("hit", "lie")]) is added
    assert add_rests(plain, [("nothing", "lie"), ("hit", "nowhere")]) is plain


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (RESTING.replace("rest: lie", "rest: lay"), r"m\.yaml:7:\d+: segment 'hop' leads to mode 'lay', which is not"),
        (
            RESTING.replace("events: {hit: y}", "events: {hit: {after: up, delay: 1}, up: y - 2}")
            .replace("initial", "  s: {mode: lie, event: up, to: fly}\ninitial")
            .replace(", direction: falling", "")
            .replace("segments: {hop: {", "segments:\n  hop: {")
            .replace("lie}}", "lie}"),
            "ends at the delayed event 'hit', where no impacts accumulate",
        ),
        (
            RESTING.replace("to: fly,", "to: [{when: v > 1, mode: fly}, {mode: lie}],"),
            "leads to mode 'lie' by a condition too",
        ),
    ],
)
def test_rest_that_cannot_be_is_refused(text, message):
    with pytest.raises(ModelError, match=message):
        model_from(text)
