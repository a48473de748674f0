"""Sizes of pictures, and that the same contents give the same bytes with text as text."""

import re
import warnings
from itertools import pairwise

import pytest

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest, apply_style, draw_picture, read_size, save_picture

ALL = ViewRequest(view="diagram", steps=("in_gain",))


@pytest.mark.parametrize(
    ("text", "width", "height"),
    [
        ("85mm", 85, 0),
        ("85", 85, 0),
        ("17cm", 170, 0),
        ("170x60mm", 170, 60),
        ("17cm x 60mm", 170, 60),
        ("2in", 50.8, 0),
    ],
)
def test_a_size_is_read(text, width, height):
    size = read_size(text)
    assert (size.width * 25.4, size.height * 25.4) == pytest.approx((width, height))


@pytest.mark.parametrize("text", ["", "wide", "0mm", "85mm x", "-3cm", "1e9mm", "85 x 5mm", "nan"])
def test_what_is_no_size_is_refused(text):
    with pytest.raises(ResultsError, match="--size"):
        read_size(text)


@pytest.mark.parametrize(("text", "width"), [("85mm", 85), ("170mm", 170), ("85x85mm", 85)])
def test_a_picture_has_the_size_and_nothing_hangs_out_of_it(every, text, width):
    size = read_size(text)
    with apply_style(size=size):
        figure = draw_picture(every, ALL)
        figure.draw_without_rendering()
        assert figure.get_figwidth() * 25.4 == pytest.approx(width)
        shown = [axes.get_tightbbox() for axes in figure.axes]
        shown += [legend.get_window_extent() for legend in figure.legends]
        for box in shown:
            assert box.x0 >= -1 and box.x1 <= figure.bbox.x1 + 1
        axes = figure.axes[-1] if size.width < 5 else figure.axes[0]
        assert axes.get_window_extent().width > 0.5 * figure.bbox.width


@pytest.mark.parametrize(("text", "n_orbits"), [("170mm", 2), ("170x80mm", 2), ("170x60mm", 1), ("170x30mm", 0)])
def test_a_low_picture_has_as_many_orbits_beside_the_diagram_as_have_room(every, text, n_orbits):
    with apply_style(size=read_size(text)), warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = draw_picture(every, ALL)
        figure.draw_without_rendering()
        assert len(figure.axes) == 1 + n_orbits
        boxes = [axes.get_tightbbox() for axes in figure.axes[1:]]
        assert all(above.y0 >= below.y1 - 1 for above, below in pairwise(boxes))


def test_a_picture_without_room_for_what_was_asked_is_refused(every, tmp_path):
    labels = [label for label in every.steps["in_gain"].labels if label][:6]
    path = tmp_path / "a.png"
    with pytest.raises(ResultsError, match="no room for all this"):
        save_picture(every, ViewRequest("diagram", ("in_gain",), labels=tuple(labels)), path, size=read_size("90x30mm"))
    assert not path.exists()


@pytest.mark.parametrize("suffix", [".svg", ".pdf", ".png"])
def test_the_same_contents_give_the_same_bytes(every, tmp_path, suffix, monkeypatch):
    found = []
    for second in ("1000000000", "1500000000"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", second)
        path = tmp_path / f"{second}{suffix}"
        save_picture(every, ALL, path)
        found.append(path.read_bytes())
    assert found[0] == found[1]


def test_text_is_text_in_an_svg(every, tmp_path):
    save_picture(every, ALL, tmp_path / "a.svg")
    text = (tmp_path / "a.svg").read_text()
    assert "top" in "".join(re.findall(r"<tspan[^>]*>(.)</tspan>", text)) and ">stable</text>" in text
