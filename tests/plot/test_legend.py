"""Legends below a figure and in its panels."""

import pytest
from matplotlib.figure import Figure

from pddecont.plot.legend import (
    MAX_COLUMNS,
    MAX_LISTED,
    add_inner_legend,
    add_legend,
    make_area_handle,
    make_line_handle,
    shorten_list,
)
from pddecont.plot.style_sheet import apply_style
from tests.plot.drawn import legend


def count_columns(figure):
    [box] = figure.legends
    return box._ncols


def test_a_legend_has_as_many_columns_as_fit():
    for words, columns in ((["a"] * 5, MAX_COLUMNS), (["a", "b"], 2), (["a" * 30] * 3, 2), (["a" * 200] * 3, 1)):
        figure = Figure(figsize=(6.4, 4.0))
        add_legend(figure, [make_line_handle(f"{word}{k}", color="red") for k, word in enumerate(words)])
        assert count_columns(figure) == columns
        assert set(legend(figure).values()) == {"red"}
        figure.draw_without_rendering()
        assert columns == 1 or figure.legends[0].get_window_extent().width <= figure.bbox.width


def test_columns_may_be_fewer_than_fit():
    figure = Figure()
    add_legend(figure, [make_area_handle(word, facecolor="red") for word in "abc"], max_columns=2)
    assert count_columns(figure) == 2


def test_the_longest_line_counts():
    figure = Figure(figsize=(6.4, 4.0))
    add_legend(figure, [make_line_handle("a\n" + "b" * 70), make_line_handle("c")])
    assert count_columns(figure) == 1


def test_without_handles_there_is_none(axes):
    add_legend(axes.figure, [])
    assert not axes.figure.legends


def test_a_panel_names_each_thing_once(axes):
    for name in ("NC", "C", "NC"):
        axes.plot([0, 1], [0, 1], label=name)
    add_inner_legend(axes, 8)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["NC", "C"]


def test_a_long_list_is_cut_and_the_rest_counted():
    handles = [make_line_handle(f"class {k}") for k in range(30)]
    assert shorten_list(handles[:MAX_LISTED]) == handles[:MAX_LISTED]
    found = shorten_list(handles)
    assert found[:-1] == handles[: MAX_LISTED - 1]
    assert found[-1].get_label() == "and 19 more"


@pytest.mark.parametrize(("n", "words"), [(8, "a" * 80), (36, "a"), (12, "a" * 60 + "\nb")])
def test_the_panels_keep_their_room_whatever_the_legend_lists(n, words):
    heights = []
    with apply_style():
        for k in (3, n):
            figure = Figure(figsize=(6.4, 4.0))
            axes = figure.subplots()
            add_legend(figure, [make_line_handle(words if k == n else "a") for _ in range(k)])
            figure.draw_without_rendering()
            heights.append(axes.get_window_extent().height / figure.dpi)
    # The figure's own size has room for a few lines.
    assert heights[1] > heights[0] - 0.5
