"""Numbers at ticks do not cover one another, by the boxes that are drawn."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from pddecont.plot import list_views
from pddecont.plot.style_sheet import apply_style
from pddecont.plot.ticks import list_label_boxes, thin_ticks


def find_overlaps(figure):
    """Return the axes of which two numbers share an area, as they are drawn."""
    figure.draw_without_rendering()
    found = []
    for axes in figure.axes:
        if not axes.get_visible() or axes.name == "3d":
            continue
        for axis in (axes.xaxis, axes.yaxis):
            boxes = list_label_boxes(axis)
            for i, a in enumerate(boxes):
                shared = np.minimum(a[2:], boxes[i + 1 :, 2:]) - np.maximum(a[:2], boxes[i + 1 :, :2])
                if np.any(np.all(shared > 0, axis=1)):
                    found.append(axis)
    return found


def make_narrow():
    """Return a figure of narrow panels over ranges whose numbers are long."""
    figure = Figure(figsize=(9.0, 3.0))
    for k, axes in enumerate(figure.subplots(1, 6)):
        axes.plot([10000.1234, 10000.1239 + 0.3 * k], [-1e-4, 0.00035 + k])
        axes.ticklabel_format(useOffset=False)
    return figure


def test_numbers_that_cover_one_another_become_fewer():
    with apply_style():
        figure = make_narrow()
        assert find_overlaps(figure)
        thin_ticks(figure)
        assert not find_overlaps(figure)
        assert all(len(list_label_boxes(axes.xaxis)) >= 1 for axes in figure.axes)


def test_ticks_that_have_room_stay():
    with apply_style():
        figure = Figure(figsize=(6.4, 4.0))
        axes = figure.subplots()
        axes.plot([0, 1], [0, 1])
        figure.draw_without_rendering()
        before = axes.get_xticks(), axes.get_yticks()
        thin_ticks(figure)
    assert all(np.array_equal(*pair) for pair in zip(before, (axes.get_xticks(), axes.get_yticks()), strict=True))


@pytest.mark.parametrize("name", ["every", "simulated"])
def test_no_picture_has_numbers_that_cover_one_another(name, show, request):
    results = request.getfixturevalue(name)
    with apply_style():
        for step in results.steps.values():
            for view in list_views(step):
                if not view.is_moving and view.name != "manifold":
                    assert not find_overlaps(show(results, view.name, (step.name,))), (step.name, view.name)
