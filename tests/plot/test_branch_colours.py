"""Colours tell families apart, else steps; a legend says so only where something differs."""

import pytest

from pddecont.plot.branch_colours import assign_branch_colours, make_style_handles, name_families
from pddecont.plot.branch_parts import Family
from pddecont.plot.style import COLOURS
from tests.plot.synthetic import point


def test_families_differ_in_colour_and_one_family_has_one(every):
    colours = assign_branch_colours([every.step("in_gain"), every.step("doubled")])
    names = ["NC C, 1 period", "NC, 1 period", "(NC C)×2, 2 periods"]
    assert colours.in_legend == list(zip(names, COLOURS, strict=False))
    assert colours.of_parts["in_gain", Family("C NC", 1)] == COLOURS[0]
    assert colours.of_parts["doubled", Family("C NC C NC", 2)] == COLOURS[2]
    assert [h.get_label() for h in colours.make_handles()] == names


def test_of_one_family_steps_differ_in_colour(every):
    steps = [every.step("in_delay"), every.step("folds")]
    assert assign_branch_colours(steps).in_legend == [("in_delay", COLOURS[0]), ("folds", COLOURS[1])]
    assert assign_branch_colours(steps[:1]).in_legend == []


def test_a_palette_begins_anew_when_it_is_used_up(every):
    colours = assign_branch_colours([every.step("in_gain")], ["red"])
    assert set(colours.of_parts.values()) == {"red"}
    assert assign_branch_colours([]).of_parts == {}


def test_families_are_called_as_they_are_first_found(every, made):
    assert name_families([every.step("in_gain")], [Family("C NC", 1)]) == ["NC C"]
    smooth = made(b=([point(0.0, 0, 3, 1, signature="")], {})).step("b")
    assert name_families([smooth], [Family("", 1)]) == ["no events"]


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([(1, 1)] * 3, []),
        ([(1, 1), (1, 1), (0, 1), (0, 1)], ["stable", "unstable"]),
        ([(-1, 1), (-1, 1), (-1, 0), (-1, 0)], ["admissible", "not admissible"]),
        ([(1, 1), (-1, 1), (-1, 0), (-1, 0)], ["stable, or not known", "not admissible"]),
    ],
)
def test_line_styles_are_named_where_there_are_several(made, rows, words):
    rows = [point(float(k), k, 3, 1, stable=s, admissible=a) for k, (s, a) in enumerate(rows)]
    assert [h.get_label() for h in make_style_handles([made(b=(rows, {})).step("b")])] == words
