"""Regions of a plane have the names of what settles there."""

import numpy as np
import pytest

from pddecont.plot.region_labels import FEWEST_PLACES, find_inside, find_regions, label_regions, number_long_names


@pytest.fixture
def halves():
    """Return places at random in a plane, of one class on the left, of another on the right, by a line x = 3."""
    places = np.random.default_rng(0).uniform([0.0, -1.0], [5.0, 1.0], (400, 2))
    return {"left": places[places[:, 0] < 3.0], "right": places[places[:, 0] > 3.0]}


def test_each_region_has_its_name_in_its_middle(halves):
    found = find_regions(halves, (0.0, 5.0, -1.0, 1.0))
    assert [name for name, *_ in found] == ["left", "right"]
    (_, left, _), (_, right, upper) = found
    assert 0.5 < left < 2.5
    assert 3.5 < right < 4.5
    assert abs(upper) < 0.5


def test_a_class_may_have_two_regions_and_few_places_have_no_name(halves):
    places = np.vstack([halves["left"][halves["left"][:, 0] < 1.5], halves["right"]])
    between = halves["left"][halves["left"][:, 0] >= 1.5]
    found = find_regions({"outside": places, "between": between}, (0.0, 5.0, -1.0, 1.0))
    assert sorted(name for name, *_ in found) == ["between", "outside", "outside"]
    lone = {"left": halves["left"], "lone": halves["right"][: FEWEST_PLACES - 1]}
    assert "lone" not in [name for name, *_ in find_regions(lone, (0.0, 5.0, -1.0, 1.0))]
    assert find_regions({}, (0.0, 1.0, 0.0, 1.0)) == []


def test_names_are_written(halves, axes):
    axes.set_xlim(0.0, 5.0)
    axes.set_ylim(-1.0, 1.0)
    label_regions(axes, halves)
    assert {text.get_text() for text in axes.texts} == {"left", "right"}


def test_long_names_are_numbered():
    assert number_long_names(["a", "b"], 3) == {"a": "a", "b": "b"}
    assert number_long_names(["a", "long name"], 3) == {"a": "1", "long name": "2"}
    assert number_long_names([], 3) == {}


def test_the_inside_of_an_image():
    image = np.zeros((5, 7), dtype=bool)
    image[1:4, 1:6] = True
    row, column = find_inside(image)
    assert row == 2
    assert column in (2, 3, 4)
