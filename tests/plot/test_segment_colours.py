"""Orbits beside a diagram have colours that mean nothing else there, and the same in every panel."""

from pddecont.plot.segment_colours import assign_segment_colours, has_several_names, list_segments
from pddecont.plot.style import COLOURS, CURVE_COLOURS
from tests.plot.drawn import legend


def colours(axes):
    """Return {segment: colour} of a phase plot."""
    return {line.get_label(): line.get_color() for line in axes.lines if not line.get_label().startswith("_")}


def named(axes):
    """Return the names in the legend of a phase plot."""
    return [text.get_text() for text in axes.get_legend().get_texts()] if axes.get_legend() else []


def test_an_orbit_of_one_segment_has_its_signature_s_colour(every, show):
    figure = show(every, "diagram", ("in_gain",), indices=(2, 20))
    _, several, one = figure.axes
    assert colours(one) == {"NC": legend(figure)["NC"]} == {"NC": COLOURS[1]}
    assert named(one) == []
    assert set(colours(several)) == {"NC", "C"}


def test_segments_have_colours_that_signatures_have_not(every, show):
    figure = show(every, "diagram", ("in_gain",))
    _, first, second = figure.axes
    assert colours(first) == colours(second) == {"NC": COLOURS[2], "C": COLOURS[3]}
    assert not set(colours(first).values()) & {legend(figure)[name] for name in ("NC C", "NC")}
    assert (named(first), named(second)) == (["NC", "C"], [])


def test_beside_curves_in_two_parameters_too(every, show):
    figure = show(every, "plane", ("grazing",), indices=(3,))
    assert CURVE_COLOURS["GR"] not in colours(figure.axes[1]).values()
    assert named(figure.axes[1]) == ["NC", "C"]


def test_orbits_by_themselves_have_one_colour_a_segment(every, show):
    one, several = show(every, "orbit", ("in_gain",), indices=(20, 2)).axes
    assert colours(one) == {"NC": COLOURS[0]}
    assert colours(several) == {"NC": COLOURS[0], "C": COLOURS[1]}
    assert (named(one), named(several)) == ([], ["NC", "C"])


def test_taken_colours_are_left_out(every):
    step = every.step("doubled")
    assert list_segments(step, 0) == ["NC", "C", "NC", "C"]
    assert has_several_names(step, 0) and not has_several_names(every.step("in_gain"), 20)
    assert assign_segment_colours([(step, 0)], COLOURS[:2]) == {"NC": COLOURS[2], "C": COLOURS[3]}
    assert len(set(assign_segment_colours([(step, 0)], COLOURS).values()) - set(COLOURS)) == 2
