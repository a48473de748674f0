"""Legends below a figure and in its panels."""

from matplotlib.figure import Figure

from pddecont.plot.legend import MAX_COLUMNS, add_inner_legend, add_legend, make_area_handle, make_line_handle
from tests.plot.drawn import legend


def count_columns(figure):
    [box] = figure.legends
    return box._ncols


def test_a_legend_has_as_many_columns_as_fit():
    for words, columns in ((["a"] * 5, MAX_COLUMNS), (["a", "b"], 2), (["a" * 50] * 3, 2), (["a" * 200] * 3, 1)):
        figure = Figure(figsize=(6.4, 4.0))
        add_legend(figure, [make_line_handle(f"{word}{k}", color="red") for k, word in enumerate(words)])
        assert count_columns(figure) == columns
        assert set(legend(figure).values()) == {"red"}


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
