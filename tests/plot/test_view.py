"""What a view is."""

from pddecont.plot import Drawing, View
from pddecont.plot.view import distinguish_kind
from pddecont.plot.views import diagram


def test_a_drawing_is_given_itself_or_by_its_place():
    own = Drawing(lambda steps, request: None)
    assert View("own", "", own).drawing is own
    assert View("other", "", "pddecont.plot.views.diagram:DRAWING").drawing is diagram.DRAWING


def test_a_view_asks_nothing_of_steps_beyond_their_kinds_unless_it_says_so(every):
    own = Drawing(lambda steps, request: None)
    step = every.step("orbit")
    assert own.can_show(step) and own.stands_alone(step)
    assert own.check_steps([step, step]) is None
    assert own.choose_steps is None and own.pick_steps is None


def test_curves_are_told_from_branches(every, resting):
    found = {name: distinguish_kind(step) for name, step in every.steps.items()}
    assert found == dict.fromkeys(("grazing", "folds"), "curve") | {"orbit": "orbit"} | dict.fromkeys(
        ("in_delay", "in_gain", "doubled"), "continue"
    )
    found = {name: distinguish_kind(resting.step(name)) for name in ("all", "resting", "hopf")}
    assert found == {"all": "equilibrium", "resting": "equilibria", "hopf": "equilibrium_curve"}
